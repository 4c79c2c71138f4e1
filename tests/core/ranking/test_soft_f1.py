# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 by reciprocal ranks, and F1 by window, against counts by hand and scikit-learn."""

import numpy as np
import pytest
from sklearn.metrics import f1_score

from w2w.core.ranking.soft_f1 import soft_f1, window_f1


def test_two_windows_by_hand():
    """Three activities: shares of the places are 6/11, 3/11 and 2/11."""
    scores = np.array([[3.0, 2.0, 1.0], [3.0, 2.0, 1.0]])
    found = soft_f1(scores, np.array([0, 1]), np.ones(2))
    first, second = 6 / 11, 3 / 11
    assert found[0] == pytest.approx(2 * first / (2 * first + 1))
    assert found[1] == pytest.approx(2 * second / (2 * second + 1))
    assert np.isnan(found[2])


def test_a_near_miss_counts_more_than_a_far_one():
    true = np.array([0, 0])
    near, far = np.array([[2.0, 3.0, 1.0]] * 2), np.array([[1.0, 3.0, 2.0]] * 2)
    assert soft_f1(near, true, np.ones(2))[0] > soft_f1(far, true, np.ones(2))[0]


def test_a_weight_of_two_is_a_window_twice():
    rng = np.random.default_rng(0)
    scores, true = rng.normal(size=(30, 4)), np.arange(30) % 4
    twice = np.r_[np.arange(30), 7]
    weight = np.ones(30)
    weight[7] = 2
    np.testing.assert_allclose(
        soft_f1(scores, true, weight), soft_f1(scores[twice], true[twice], np.ones(31))
    )


def test_f1_by_window_equals_scikit_learns():
    rng = np.random.default_rng(1)
    true, named = rng.integers(0, 5, 200), rng.integers(0, 5, 200)
    np.testing.assert_allclose(window_f1(named, true, 5), f1_score(true, named, average=None))
