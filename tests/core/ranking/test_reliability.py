# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a map repeats, and how many clips it takes: where signal and noise are known, so is the answer."""

import numpy as np
import pytest

from w2w.core.ranking.costs import is_as_good
from w2w.core.ranking.expected import agreement, clips_needed, expect, of_all
from w2w.core.ranking.halves import CrossValidation, plan
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map

from ...rings import by_day

pytestmark = pytest.mark.later

N, A = 200, 3


def clips(n):
    clip = np.repeat(np.arange(A * n), 2)
    return clip % A, clip, clip // A % 5, np.ones(len(clip), bool)


def mean_reliability(signal, noise, clips_of_an_activity=20, seeds=4, n_patches=N):
    """Of maps whose patches differ by `signal`, and by `noise` for each clip they are made of."""
    found = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        truth = signal * rng.normal(size=(1, n_patches))
        work = plan(*clips(clips_of_an_activity), seed=seed)
        of_a_half = noise / np.sqrt(clips_of_an_activity / 2)
        halves = [truth + of_a_half * rng.normal(size=(A, n_patches)) for _ in range(2 * len(work.pairs))]
        maps = np.stack([(halves[0] + halves[1]) / 2, *halves])
        pooling = Pooling.none(n_patches)
        found.append(expect(maps, work, pooling, 0.95).reliability)
    return np.mean(found)


@pytest.mark.parametrize(("signal", "noise"), [(0.1, 0.1), (0.1, 0.4), (0.05, 0.5)])
def test_reliability_is_the_share_of_signal_in_what_varies(signal, noise):
    """Of the mean over `A` activities of all 20 clips each."""
    true = signal**2 / (signal**2 + noise**2 / (A * 20))
    assert mean_reliability(signal, noise, seeds=8) == pytest.approx(true, abs=0.04)


def test_as_many_clips_as_are_said_to_do_give_what_they_are_said_to_give():
    few = mean_reliability(0.1, 0.9, 8)
    assert few < 0.3
    enough = round(8 * clips_needed(few))
    assert mean_reliability(0.1, 0.9, enough) == pytest.approx(0.85, abs=0.04)


def test_noise_alone_is_not_reliable():
    assert mean_reliability(0.0, 0.3, seeds=8) == pytest.approx(0, abs=0.05)


def test_the_formula_and_its_inverse():
    assert of_all(0.71) == pytest.approx(0.8304, abs=1e-4)
    assert clips_needed(of_all(0.71)) == pytest.approx(1.157, abs=1e-3)
    assert clips_needed(0.85) == pytest.approx(1)
    assert clips_needed(0.0) == clips_needed(-0.3) == np.inf
    assert np.isnan(clips_needed(np.nan))


def test_flat_maps_agree_with_none():
    slope = np.arange(5.0)
    assert agreement([(slope, 2 * slope)]) == pytest.approx(1)
    assert agreement([(slope, slope), (np.ones(5), slope)]) == pytest.approx(0.5)
    assert np.isnan(agreement([]))


def classified(shuffled, seed, equal=False):
    """A ranking of 30 patches, the first of which hear more of the activity than the last."""
    rng = np.random.default_rng(seed)
    activity, clip, _, every = clips(24)
    features = rng.normal(size=(len(activity), 30, 4)).astype(np.float32)
    strength = np.linspace(1.5, 0, 30)
    for a in range(A):
        features[activity == a, :, a] += strength
    if equal:
        features[:] = features[:, 10:11]
    if shuffled:
        activity = rng.permutation(activity.reshape(-1, 2)[:, 0]).repeat(2)
    names = np.array([f"activity {a}" for a in range(A)])
    protocol = CrossValidation(names[activity], clip, None, every, list(names), folds=3, seed=seed)
    return utility_map(features, protocol, resamples=20)


@pytest.mark.slow
def test_shuffled_labels_give_a_reliability_near_nought_and_cannot_rank():
    found = [classified(True, seed) for seed in range(5)]
    assert np.mean([one.reliability for one in found]) == pytest.approx(0, abs=0.2)
    assert np.mean([one.can_rank for one in found]) < 0.25
    true = classified(False, 0)
    assert true.can_rank
    assert true.reliability > 0.85


@pytest.mark.parametrize("shuffled", by_day([True], [True, False]))
def test_patches_that_are_all_equal_rank_nothing(shuffled):
    found = classified(shuffled, 0, equal=True)
    assert is_as_good(found.expected_mean.max() - found.expected_mean).all()
    assert not found.can_rank
    np.testing.assert_allclose(found.expected_mean, found.expected_mean[0], rtol=1e-5)
    assert found.expected_mean[0] == pytest.approx(found.mean.mean(), abs=0.03)  # which has one set of folds


@pytest.mark.slow
def test_the_best_spot_never_promises_less_than_an_average_one_has():
    for seed in range(8):
        found = classified(True, seed)
        lead = found.expected_mean.max() - found.mean.mean()
        assert lead >= -1e-6
        assert not found.can_rank or lead > 0


def test_two_clips_an_activity_cannot_be_halved():
    activity, clip, _, every = clips(3)
    features = np.random.default_rng(0).normal(size=(len(activity), 6, 3)).astype(np.float32)
    names = np.array(list("abc"))
    utility = utility_map(
        features, CrossValidation(names[activity], clip, None, every, list(names)), resamples=20
    )
    assert np.isnan(utility.reliability)
    assert not utility.can_rank
