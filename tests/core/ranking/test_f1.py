# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 from counts equals scikit-learn's, and bootstrap intervals cover what they should."""

import numpy as np
import pytest
from sklearn.metrics import confusion_matrix, f1_score

from w2w.core.ranking import f1
from w2w.core.ranking.f1 import ClipUnits, clip_resamples, confusion_of, f1_scores, score_patches


def simulate(rng, n_clips=30, n_activities=3, n_sensors=1, right=0.7, clip_spread=0.2):
    """Windows of clips; each clip has its own chance of being recognised."""
    truth, clip, predictions = [], [], []
    for number in range(n_clips * n_activities):
        activity = number % n_activities
        chance = np.clip(right + clip_spread * rng.normal(), 0, 1)
        n_windows = rng.integers(1, 6)
        named = np.where(
            rng.random((n_windows, n_sensors)) < chance,
            activity,
            rng.integers(0, n_activities, (n_windows, n_sensors)),
        )
        truth += [activity] * n_windows
        clip += [number] * n_windows
        predictions.append(named)
    return np.array(truth), np.concatenate(predictions), np.array(clip)


def test_f1_and_confusion_equal_scikit_learn():
    truth, predictions, clip = simulate(np.random.default_rng(0), n_sensors=4)
    counts = ClipUnits(truth, clip, 3).count(predictions)
    f1 = f1_scores(counts, np.ones((1, len(counts.size))))[0]
    for sensor in range(4):
        expected = f1_score(truth, predictions[:, sensor], average=None)
        np.testing.assert_allclose(f1[sensor], expected, rtol=1e-6)
        expected = confusion_matrix(truth, predictions[:, sensor])
        np.testing.assert_array_equal(confusion_of(truth, predictions, 3)[sensor], expected)


def test_weights_are_repetitions_of_clips():
    rng = np.random.default_rng(1)
    truth, predictions, clip = simulate(rng, n_clips=5, n_sensors=2)
    counts = ClipUnits(truth, clip, 3).count(predictions)
    weights = rng.integers(0, 3, size=15)
    weights[:3] = 1
    repeated = np.concatenate([np.flatnonzero(clip == c) for c in range(15) for _ in range(weights[c])])
    f1 = f1_scores(counts, weights[None])[0]
    for sensor in range(2):
        expected = f1_score(truth[repeated], predictions[repeated, sensor], average=None)
        np.testing.assert_allclose(f1[sensor], expected, rtol=1e-6)


def test_resamples_keep_the_number_of_clips_of_each_activity():
    activity = np.array([0, 0, 0, 1, 1, 2])
    weights = clip_resamples(activity, 2000, np.random.default_rng(2))
    for label, n_clips in ((0, 3), (1, 2), (2, 1)):
        np.testing.assert_array_equal(weights[:, activity == label].sum(axis=1), n_clips)
    np.testing.assert_allclose(weights.mean(axis=0), 1.0, atol=0.06)


@pytest.mark.slow
def test_interval_covers_the_true_macro_f1():
    """95 % intervals over 30 clips an activity must cover at least 85 % of the time, and not always."""
    rng = np.random.default_rng(3)
    truth, predictions, clip = simulate(rng, n_clips=6000)
    counts = ClipUnits(truth, clip, 3).count(predictions)
    true_f1 = f1_scores(counts, np.ones((1, len(counts.size)))).mean()
    covered = 0
    for seed in range(100):
        _, boot = score_patches(*simulate(rng), 3, 200, 0.95, seed)
        covered += boot.mean_low[0] <= true_f1 <= boot.mean_high[0]
    assert 85 <= covered < 100


def test_ranks_of_clearly_different_sensors_are_certain_and_of_equal_ones_are_not():
    rng = np.random.default_rng(4)
    truth, weak, clip = simulate(rng, n_clips=60, n_sensors=4, right=0.4)
    strong = np.where(rng.random((len(truth), 1)) < 0.95, truth[:, None], (truth[:, None] + 1) % 3)
    _, boot = score_patches(truth, np.hstack([weak, strong]), clip, 3, 300, 0.95, 4)
    assert (boot.rank_low[4], boot.rank_high[4]) == (1, 1)
    assert (boot.rank_low[:4] >= 2).all()
    assert (boot.rank_high[:4] - boot.rank_low[:4] >= 1).all()


def test_blocks_of_sensors_change_nothing(monkeypatch):
    truth, predictions, clip = simulate(np.random.default_rng(5), n_sensors=7)
    whole = score_patches(truth, predictions, clip, 3, 50, 0.9, 0)
    monkeypatch.setattr(f1, "COUNT_BYTES", 3 * 3 * 4 * len(np.unique(clip)))
    monkeypatch.setattr(f1, "SAMPLE_BYTES", 5 * 2 * 3 * 50 * 4)  # of five sensors, counted three at a time
    parts = score_patches(truth, predictions, clip, 3, 50, 0.9, 0)
    for a, b in zip((whole[0], *whole[1]), (parts[0], *parts[1]), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-6)


def test_blocks_of_clips_and_of_draws_change_nothing(monkeypatch):
    truth, predictions, clip = simulate(np.random.default_rng(6), n_sensors=3)
    whole = score_patches(truth, predictions, clip, 3, 50, 0.9, 0)
    monkeypatch.setattr(f1, "CLIPS_AT_ONCE", 7)
    monkeypatch.setattr(f1, "RESAMPLES_AT_ONCE", 9)
    parts = score_patches(truth, predictions, clip, 3, 50, 0.9, 0)
    for a, b in zip((whole[0], *whole[1]), (parts[0], *parts[1]), strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_clip_under_two_activities_counts_as_two():
    counts = ClipUnits(np.array([0, 0, 1]), np.array(["s", "s", "s"]), 2).count(np.array([[0], [1], [1]]))
    np.testing.assert_array_equal(counts.size, [2, 1])
    np.testing.assert_array_equal(counts.correct[:, 0], [1, 1])
    np.testing.assert_array_equal(counts.predicted[:, 0], [[1, 1], [0, 1]])


def test_an_activity_without_windows_has_no_f1_even_where_it_is_named():
    counts = ClipUnits(np.array([0, 0, 2]), np.array([0, 0, 1]), 3).count(np.array([[1], [0], [2]]))
    np.testing.assert_allclose(f1_scores(counts, np.ones((1, 2)))[0, 0], [2 / 3, np.nan, 1])
