# SPDX-License-Identifier: GPL-3.0-or-later
"""Which places say the same: correlation of classifications and clusters of it."""

import numpy as np
import pytest
from sklearn.metrics import matthews_corrcoef

from w2w.core.selection import advice
from w2w.core.selection.advice import prediction_correlation, redundancy_clusters


def test_correlation_is_the_multi_class_matthews_coefficient():
    rng = np.random.default_rng(0)
    predictions = rng.integers(0, 4, size=(300, 6))
    predictions[:150, 1] = predictions[:150, 0]
    found = prediction_correlation(predictions, 4)
    for i in range(6):
        for j in range(6):
            expected = matthews_corrcoef(predictions[:, i], predictions[:, j])
            assert found[i, j] == pytest.approx(expected, abs=1e-6)


def test_correlation_is_the_same_however_many_windows_are_looked_at_at_once(monkeypatch):
    predictions = np.random.default_rng(3).integers(0, 4, size=(301, 5))
    predictions[:200, 1] = predictions[:200, 0]
    whole = prediction_correlation(predictions, 4)
    monkeypatch.setattr(advice, "WINDOWS_AT_ONCE", 50)
    np.testing.assert_allclose(prediction_correlation(predictions, 4), whole, atol=1e-6)


def test_three_families_of_places_are_found_largest_first():
    rng = np.random.default_rng(1)
    family = np.array([1, 0, 0, 2, 1, 0, 0, 2, 1, 0])
    said = rng.integers(0, 5, size=(600, 3))
    predictions = said[:, family]
    mistaken = rng.random(predictions.shape) < 0.05
    predictions = np.where(mistaken, rng.integers(0, 5, size=predictions.shape), predictions)
    np.testing.assert_array_equal(redundancy_clusters(predictions, 5, 0.8), family)
    assert len(set(redundancy_clusters(predictions, 5, 0.999))) == 10


@pytest.mark.parametrize(("differ", "clusters"), [(36, 1), (44, 2)])
def test_places_are_of_one_opinion_from_a_correlation_of_four_fifths_on(differ, clusters):
    """Of 400 windows in two activities, as many differ as make a correlation of .82, or .78."""
    predictions = np.tile(np.arange(400) % 2, (2, 1)).T
    predictions[:differ, 1] = 1 - predictions[:differ, 1]
    assert prediction_correlation(predictions, 2)[0, 1] == pytest.approx(1 - 2 * differ / 400)
    assert len(set(redundancy_clusters(predictions, 2))) == clusters


def test_a_place_that_always_says_one_thing_correlates_with_none():
    predictions = np.stack([np.zeros(50, int), np.arange(50) % 3, np.zeros(50, int)], axis=1)
    np.testing.assert_array_equal(prediction_correlation(predictions, 3), np.eye(3))
    assert redundancy_clusters(predictions[:, :1], 3).tolist() == [0]
