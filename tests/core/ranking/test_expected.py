# SPDX-License-Identifier: GPL-3.0-or-later
"""Expected scores: equal patches stay equal, intervals hold what other clips give, a real lead is found."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import norm

from w2w.core.ranking.costs import is_as_good
from w2w.core.ranking.expected import LIKELY, SURE, expect, most_shown
from w2w.core.ranking.halves import plan
from w2w.core.ranking.pooling import Pooling

N, A = 200, 5


def clips(n=40):
    clip = np.repeat(np.arange(A * n), 2)
    return clip % A, clip, clip // A % 5, np.ones(len(clip), bool)


@cache
def planned(seed):
    return plan(*clips(), seed=seed)


def world(truth, level_noise, noise, seed):
    """Maps of a plan's trials, whose noise halves with the number of clips, and another library's."""
    rng = np.random.default_rng(seed)
    work = planned(seed % 5)
    raw = []
    for _ in work.pairs:
        two = [
            truth + level_noise * np.sqrt(2) * rng.normal() + noise * np.sqrt(2) * rng.normal(size=(A, N))
            for _ in range(2)
        ]
        raw += two
    whole = (raw[0] + raw[1]) / 2
    other = truth + level_noise * rng.normal() + noise * rng.normal(size=(A, N))
    maps = np.stack([whole, *raw])
    return expect(maps, work, Pooling.none(N), 0.95), other


def test_patches_that_are_all_equal_do_as_well_and_are_said_not_to_be_told_apart():
    found = [world(np.full((A, N), 0.5), 0.01, 0.05, seed)[0] for seed in range(20)]
    costs = [each.expected_mean.max() - each.expected_mean for each in found]
    assert is_as_good(np.array(costs)).mean() > 0.9
    assert np.mean([each.beats_average >= LIKELY for each in found]) < 0.2


def test_a_real_lead_is_found_and_promised_as_it_is():
    rng = np.random.default_rng(5)
    promised, given, lead = [], [], []
    for seed in range(15):
        truth = np.repeat(0.5 + 0.1 * rng.normal(size=(1, N)), A, axis=0)
        found, other = world(truth, 0.01, 0.1, seed)
        best = found.expected_mean.argmax()
        assert found.beats_average >= SURE
        assert is_as_good(found.expected_mean.max() - found.expected_mean).mean() < 0.2
        promised.append(found.expected_mean[best])
        given.append(other.mean(axis=0)[best])
        lead.append(truth[0, best] - 0.5)
    assert np.mean(lead) > 0.15
    assert np.mean(promised) == pytest.approx(np.mean(given), abs=0.03)


@pytest.mark.slow
def test_where_clips_are_said_to_rank_the_best_patch_beats_the_average_nine_times_in_ten():
    """Its chance on other clips is known: that its true lead is more than their noise."""
    noise, chances = 0.1, []
    for seed in range(30):
        for spread in (0.02, 0.03, 0.04):
            lead = spread * np.random.default_rng(seed).normal(size=(1, N))
            found, _ = world(np.repeat(0.5 + lead, A, axis=0), 0.01, noise, seed)
            if found.beats_average >= SURE:
                over = lead[0, found.expected_mean.argmax()] - lead.mean()
                chances.append(norm.cdf(over / (noise / np.sqrt(A))))
    assert len(chances) > 10
    assert np.mean(chances) > 0.87


def test_a_peak_that_pooling_has_flattened_is_not_made_steeper_again():
    place = np.arange(N)
    kernel = np.exp(-0.5 * np.abs(place[:, None] - place) ** 2)
    pooling = Pooling(kernel / kernel.sum(axis=1, keepdims=True), np.eye(N))
    truth = np.full((A, N), 0.5)
    truth[:, N // 2] = 0.9
    work = planned(0)
    found = expect(np.tile(truth, (1 + 2 * len(work.pairs), 1, 1)), work, pooling, 0.95)
    np.testing.assert_allclose(found.expected_mean, pooling.apply(truth)[0], atol=1e-6)


def test_the_naive_promise_would_be_too_high():
    found, other = zip(*(world(np.full((A, N), 0.5), 0.0, 0.1, seed) for seed in range(20)), strict=True)
    delivered = np.mean([o.mean(axis=0)[f.expected_mean.argmax()] for f, o in zip(found, other, strict=True)])
    assert np.mean([f.expected_mean.max() for f in found]) == pytest.approx(delivered, abs=0.02)


@pytest.mark.later
def test_intervals_hold_other_clips_f1_about_as_often_as_two_samples_of_one_thing_should():
    """An interval that holds the truth 95 times in 100 holds a second sample some 83 times."""
    rng = np.random.default_rng(0)
    held = []
    for seed in range(40):
        truth = np.repeat(0.5 + 0.05 * rng.normal(size=(1, N)), A, axis=0)
        found, other = world(truth, 0.03, 0.05, seed)
        mean = other.mean(axis=0)
        held.append(((found.expected_low <= mean) & (mean <= found.expected_high)).mean())
    assert 0.7 < np.mean(held) < 0.95


def test_intervals_narrow_where_all_clips_bring_f1_nearer_to_one_than_halves_do():
    """Errors of a share p of so many clips vary by p (1 - p) over their number."""
    rng = np.random.default_rng(1)
    work = planned(1)
    noise = 0.05 * rng.normal(size=(2 * len(work.pairs), A, N))
    widths = []
    for whole, halves in ((0.5, 0.5), (0.9, 0.8), (0.9, 0.9)):
        maps = np.concatenate([whole + noise[:1] / 2, halves + noise])
        found = expect(maps, work, Pooling.none(N), 0.95)
        widths.append(np.median(found.expected_high - found.expected_low))
    alike, nearer, still = widths
    assert nearer == pytest.approx(alike * np.sqrt(0.9 * 0.1 / (0.8 * 0.2)), rel=0.06)
    assert still == pytest.approx(alike, rel=0.02)


@pytest.mark.slow
def test_intervals_hold_the_truth_where_few_halvings_tell_of_the_level():
    held = []
    for seed in range(80):
        rng = np.random.default_rng(100 + seed)
        truth = np.repeat(0.5 + 0.02 * rng.normal(size=(1, N)), A, axis=0)
        found, _ = world(truth, 0.05, 0.02, seed)
        held.append(((found.expected_low <= truth[0]) & (truth[0] <= found.expected_high)).mean())
    assert np.mean(held) > 0.885


def test_f1_of_one_everywhere_leaves_an_interval():
    work = planned(2)
    halves = 0.9 + 0.05 * np.random.default_rng(2).normal(size=(2 * len(work.pairs), A, N))
    maps = np.concatenate([np.ones((1, A, N)), halves])
    found = expect(maps, work, Pooling.none(N), 0.95)
    assert (found.expected_high > found.expected_low).all()


def test_patches_without_any_lead_beat_no_average():
    work = planned(2)
    found = expect(np.ones((1 + 2 * len(work.pairs), A, N)), work, Pooling.none(N), 0.95)
    assert found.beats_average == 0


def test_clips_that_cannot_be_halved_rank_nothing():
    clip = np.repeat(np.arange(3 * A), 2)
    work = plan(clip % A, clip, clip // A, np.ones(len(clip), bool))
    raw = np.random.default_rng(0).uniform(size=(1, A, N))
    found = expect(raw, work, Pooling.none(N), 0.95)
    assert found.beats_average < LIKELY
    assert not len(found.errors)
    assert (found.expected_low == 0).all()
    assert (found.expected_high == 1).all()
    assert np.ptp(found.expected_mean) < np.ptp(raw[0].mean(axis=0))


def test_so_many_clips_cannot_show_more():
    clips = np.repeat(np.arange(12).astype(str), 3)
    assert most_shown(clips, 0.95) == pytest.approx(0.735, abs=1e-3)  # Clopper and Pearson, 12 of 12
    assert most_shown(np.arange(400).astype(str), 0.95) > 0.99
