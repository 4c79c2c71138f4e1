# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of F1: the map's own numbers, groups, means, and what cannot be told from the best."""

import numpy as np
import pytest
from sklearn.metrics import f1_score

from tests.core.ranking.test_f1 import simulate
from w2w.core.ranking.f1 import score_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.placements.score_table import resampled_f1, score_table

ACTIVITIES = ("bow", "jump", "run", "walk")
GROUPS = {"run": "moving", "walk": "moving", "jump": "sport"}


@pytest.fixture(scope="module")
def utility():
    """Place 0 says nothing, 1 and 2 nearly the same and much, 3 everything."""
    rng = np.random.default_rng(2)
    activity = np.repeat(ACTIVITIES, 60)
    clip = np.arange(240) // 5
    centres = rng.normal(size=(4, 6))[np.searchsorted(ACTIVITIES, activity)]
    noise = rng.normal(size=(240, 3, 6))
    features = np.stack([noise[:, 0], centres + noise[:, 1], centres + noise[:, 1], 9 * centres], axis=1)
    features[:, 2] += 0.01 * noise[:, 2]
    everything = np.ones(240, bool)
    return utility_map(
        features.astype(np.float32), CrossValidation(activity, clip, None, everything, ACTIVITIES)
    )


def test_rows_are_the_map_in_groups(utility):
    rows = score_table(utility, [3, 0, 1], GROUPS)
    assert [(row.group, row.activity) for row in rows] == [
        ("moving", "run"),
        ("moving", "walk"),
        ("moving", ""),
        ("sport", "jump"),
        ("", "bow"),
        ("", ""),
    ]
    for row in rows:
        assert (row.low <= row.f1 + 1e-6).all()
        assert (row.f1 <= row.high + 1e-6).all()
        if row.activity:
            column = ACTIVITIES.index(row.activity)
            expected = f1_score(
                utility.truth, utility.predictions[:, [3, 0, 1]].T[1], labels=[column], average=None
            )
            np.testing.assert_allclose(row.f1, utility.f1[[3, 0, 1], column], rtol=1e-6)
            assert row.f1[1] == pytest.approx(expected[0])
            assert (row.clips, row.windows) == (12, 60)
    np.testing.assert_allclose(rows[2].f1, (rows[0].f1 + rows[1].f1) / 2, rtol=1e-6)
    np.testing.assert_allclose(rows[-1].f1, utility.mean[[3, 0, 1]], rtol=1e-6)
    assert (rows[-1].clips, rows[-1].windows) == (48, 240)


def test_intervals_are_those_of_the_map_but_for_the_draws(utility):
    overall = score_table(utility, range(4), {}, resamples=4000)[-1]
    np.testing.assert_allclose(overall.low, utility.mean_low, atol=0.03)
    np.testing.assert_allclose(overall.high, utility.mean_high, atol=0.03)


def test_only_what_differs_for_sure_is_called_worse(utility):
    overall = score_table(utility, [0, 1, 2], {})[-1]
    assert overall.best.tolist() == [False, True, True]
    assert score_table(utility, [0, 1, 2, 3], {})[-1].best.tolist() == [False, False, False, True]


def test_one_group_has_no_mean_of_its_own(utility):
    assert len(score_table(utility, [0, 1], {})) == 5


def test_the_same_seed_draws_the_same_clips_for_a_map_and_for_a_few_of_its_places():
    truth, predictions, clip = simulate(np.random.default_rng(6), n_sensors=7)
    f1, boot = score_patches(truth, predictions, clip, 3, 50, 0.9, 1)
    few, samples = resampled_f1(truth, predictions[:, [5, 2]], clip, 3, 50, 1)
    np.testing.assert_array_equal(few, f1[[5, 2]])
    np.testing.assert_array_equal(samples.mean(axis=2), boot.mean_samples[:, [5, 2]])
    low, high = np.quantile(samples, [0.05, 0.95], axis=0)
    np.testing.assert_allclose(low, boot.f1_low[[5, 2]], rtol=1e-6)
    np.testing.assert_allclose(high, boot.f1_high[[5, 2]], rtol=1e-6)
