# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals stand where theory has them, draws follow the seed, ties go to the first."""

from dataclasses import fields

import numpy as np
import pytest
from scipy.stats import binom, norm

from w2w.core.ranking.f1 import score_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.selection.scored import best_single

from ...rings import by_day

CLIPS = 400
RESAMPLES = 4000


def half_right(clips=CLIPS):
    """One window a clip. Half of the first activity's clips are named the second, all else is right.

    Its hits among resampled clips are binomial.
    """
    truth = np.repeat([0, 1], clips)
    named = truth.copy()
    named[: clips // 2] = 1
    return truth, named[:, None], np.arange(2 * clips)


@pytest.mark.parametrize("level", by_day([0.5, 0.95], [0.5, 0.9, 0.95, 0.99]))
def test_bounds_are_the_quantiles_of_a_binomial(level):
    _, found = score_patches(*half_right(), 2, RESAMPLES, level, seed=1)
    tails = np.array([(1 - level) / 2, (1 + level) / 2])
    hits = binom.ppf(tails, CLIPS, 0.5)
    # how far a quantile of so many draws strays: three standard deviations, and half a hit for the steps
    density = norm.pdf(norm.ppf(tails)) / (np.sqrt(CLIPS) / 2)
    stray = 3 * np.sqrt(tails * (1 - tails) / RESAMPLES) / density + 0.5
    if level == 0.95:
        assert (stray < 2).all()  # 90 % would be off by 3.2
    for bound, hit, tolerance in zip((0, 1), hits, stray, strict=True):
        first = (found.f1_low, found.f1_high)[bound][0, 0]
        assert CLIPS * first / (2 - first) == pytest.approx(hit, abs=tolerance)
        near = np.array([hit - tolerance, hit, hit + tolerance])
        macro = near / (near + CLIPS) + CLIPS / (3 * CLIPS - near)
        assert macro[0] < (found.mean_low, found.mean_high)[bound][0] < macro[2]


def steady_and_chancy(right):
    """Ten windows a clip. One place names six in ten of every clip of the first activity rightly.

    The other names all of some clips, none of the others.
    """
    truth = np.repeat([0, 1], 10 * CLIPS)
    named = np.stack([truth, truth], axis=1)
    first = named[: 10 * CLIPS]
    first[np.arange(10 * CLIPS) % 10 >= 6, 0] = 1
    first[10 * right :, 1] = 1
    return truth, named, np.repeat(np.arange(2 * CLIPS), 10)


@pytest.mark.slow
def test_ranks_hold_what_more_than_the_tail_of_the_resamples_say():
    """The steady place wins in 3.4 % of the resamples: within 95 %, beyond 90 %."""
    right = 257
    chance = binom.cdf(0.6 * CLIPS - 1, CLIPS, right / CLIPS)
    assert 0.030 < chance < 0.040
    for level, steady, chancy in ((0.95, (1, 2), (1, 2)), (0.90, (2, 2), (1, 1))):
        _, found = score_patches(*steady_and_chancy(right), 2, RESAMPLES, level, seed=2)
        assert (found.rank_low[0], found.rank_high[0]) == steady
        assert (found.rank_low[1], found.rank_high[1]) == chancy


def test_places_that_do_alike_share_the_better_rank():
    truth, named, clip = half_right(20)
    worse = 1 - truth[:, None]
    _, found = score_patches(truth, np.hstack([named, worse, named]), clip, 2, 50, 0.95, seed=0)
    assert found.rank_low.tolist() == found.rank_high.tolist() == [1, 3, 1]


def test_draws_are_those_of_the_seed():
    truth, named, clip = half_right(30)
    one, again, other = (score_patches(truth, named, clip, 2, 40, 0.95, seed)[1] for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.mean_samples, again.mean_samples)
    assert (one.mean_samples != other.mean_samples).any()
    # the first activity's clips are drawn first
    drawn = np.random.default_rng(3).multinomial(30, np.full(30, 1 / 30), size=40)
    hits = drawn[:, 15:].sum(axis=1)
    expected = hits / (hits + 30) + 30 / (90 - hits)
    np.testing.assert_allclose(one.mean_samples[:, 0], expected, rtol=1e-6)


class Fixed:
    """A classifier that has made up its mind."""

    name, inputs = "fixed", "features"

    def predict_folds(self, source, labels, fold, is_test, progress):
        del source, fold, progress
        return half_right(len(labels) // 2)[1][is_test]


def test_the_map_takes_its_draws_and_seed_from_its_arguments():
    truth, _, clip = half_right(40)
    inputs, activity = np.zeros((len(truth), 1, 1), np.float32), np.array(["bow", "walk"])[truth]

    def made(seed):
        every = np.ones(len(truth), bool)
        protocol = CrossValidation(activity, clip, None, every, ("bow", "walk"), seed=seed)
        return utility_map(inputs, protocol, Fixed(), resamples=300)

    base = made(seed=5)
    assert base.mean_samples.shape == (300, 1)
    _, direct = score_patches(*half_right(40), 2, 300, 0.95, 5)
    np.testing.assert_array_equal(base.mean_samples, direct.mean_samples)
    assert (base.mean_low, base.mean_high) == (direct.mean_low, direct.mean_high)
    other = made(seed=6)
    np.testing.assert_array_equal(base.predictions, other.predictions)
    assert (base.mean_samples != other.mean_samples).any()


def map_of(mean, mean_samples=None, level=0.95) -> UtilityMap:
    """A map of which only the macro F1 matters."""
    mean = np.asarray(mean, dtype=np.float32)
    given = dict.fromkeys((field.name for field in fields(UtilityMap)), np.zeros(0))
    given |= {"activities": ("walk",), "f1": mean[:, None], "expected_mean": mean, "level": level}
    return UtilityMap(**given | {"mean_samples": mean[None] if mean_samples is None else mean_samples})


def test_the_first_of_equally_good_places_is_the_best():
    assert best_single(map_of([0.5, 0.8, 0.7, 0.8, 0.8])) == 1
    assert best_single(map_of([0.8, 0.8]), np.array([False, True])) == 1
    assert best_single(map_of([0.9, 0.1, 0.3, 0.3]), np.array([False, True, True, True])) == 2
