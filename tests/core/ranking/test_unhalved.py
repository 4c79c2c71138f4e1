# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities of too few clips to be halved: they count, and their noise widens the interval."""

import numpy as np
import pytest

from w2w.core.ranking.expected import Unhalved, expect
from w2w.core.ranking.halves import plan
from w2w.core.ranking.pooling import Pooling

N = 200


def few_and_many(few=8, clips_of_many=40):
    """Labels of two activities of many clips and others of three, as `plan` takes them."""
    number = np.array([clips_of_many] * 2 + [3] * few)
    activity = np.repeat(np.repeat(np.arange(len(number)), number), 2)
    clip = np.repeat(np.arange(number.sum()), 2)
    return activity, clip, clip % 5, np.ones(len(clip), bool)


@pytest.mark.slow
def test_their_signal_counts_and_their_noise_is_in_the_interval():
    """Two of ten activities rank the patches firmly; three clips of each other do, too, with more noise."""
    rng = np.random.default_rng(7)
    promised, given, held = [], [], []
    noise = 0.04 * np.sqrt(40 / np.array([40] * 2 + [3] * 8))[:, None]
    for seed in range(30):
        work = plan(*few_and_many(), seed=seed)
        truth = 0.5 + 0.1 * np.repeat(rng.normal(size=(1, N)), 10, axis=0)
        halves = [truth + noise * np.sqrt(2) * rng.normal(size=(10, N)) for _ in range(2 * len(work.pairs))]
        maps = np.stack([truth + noise * rng.normal(size=(10, N)), *halves])
        found = expect(maps, work, Pooling.none(N), 0.95)
        other = (truth + noise * rng.normal(size=(10, N))).mean(axis=0)
        best = found.expected_mean.argmax()
        promised.append(found.expected_mean[best] - found.expected_mean.mean())
        given.append(truth.mean(axis=0)[best] - truth.mean())
        held.append(((found.expected_low <= other) & (other <= found.expected_high)).mean())
    assert np.mean(given) > 0.15
    assert np.mean(promised) == pytest.approx(np.mean(given), abs=0.03)
    assert 0.8 < np.mean(held) <= 1


def halves_of_noise(rng, clips, noise, pairs=6):
    """Maps of halves of activities of so many clips, of which a clip's is off by `noise`."""
    of_half = noise / np.sqrt(np.array(clips) / 2)[:, None]
    return [tuple(of_half * rng.normal(size=(2, len(clips), N))) for _ in range(pairs)]


def test_noise_falls_with_the_clips():
    rng = np.random.default_rng(0)
    clips = np.array([40, 10, 2, 3])
    rest = Unhalved.of(np.ones(4), np.array([True, True, False, False]), clips)
    pooled = halves_of_noise(rng, clips[:2], 0.3, pairs=60)
    assert rest.halved == 0.5
    assert rest.rows.tolist() == [False, False, True, True]
    assert rest.noise(pooled) == pytest.approx(0.3**2 * (1 / 2 + 1 / 3) / 4**2, rel=0.2)


@pytest.mark.parametrize("signal", [0.0, 0.1, 0.3])
def test_of_their_contrast_what_is_beyond_noise_repeats(signal):
    rng = np.random.default_rng(1)
    clips = np.array([40, 10, 2, 3])
    rest = Unhalved.of(np.ones(4), np.array([True, True, False, False]), clips)
    pooled = halves_of_noise(rng, clips[:2], 0.3, pairs=60)
    shares, variances = [], []
    for _ in range(20):
        noise = 0.3 / np.sqrt(clips[2:, None]) * rng.normal(size=(2, N))
        share, variance = rest.repeat(signal * rng.normal(size=(2, N)) + noise, pooled, pooled)
        shares.append(share)
        variances.append(variance)
    true = 2 * signal**2 / (2 * signal**2 + 0.3**2 * (1 / 2 + 1 / 3))
    assert np.mean(shares) == pytest.approx(true, abs=0.07)
    assert np.mean(variances) == pytest.approx(2 * rest.noise(pooled), rel=0.07)


@pytest.mark.slow
def test_the_chance_of_beating_an_average_place_is_right_where_most_activities_are_rare():
    """Two activities of 40 clips and eight of three that share no signal worth speaking of."""
    noise = 0.04 * np.sqrt(40 / np.array([40] * 2 + [3] * 8))[:, None]
    stated, did = [], []
    for seed in range(60):
        rng, work = np.random.default_rng(seed), plan(*few_and_many(), seed=seed)
        truth = 0.5 + np.repeat(0.01 * rng.normal(size=(1, N)), 10, axis=0)
        halves = [truth + noise * np.sqrt(2) * rng.normal(size=(10, N)) for _ in range(2 * len(work.pairs))]
        maps = np.stack([truth + noise * rng.normal(size=(10, N)), *halves])
        found = expect(maps, work, Pooling.none(N), 0.95)
        other = (truth + noise * rng.normal(size=(10, N))).mean(axis=0)
        stated.append(found.beats_average)
        did.append(other[found.expected_mean.argmax()] > other.mean())
    assert np.mean(stated) == pytest.approx(np.mean(did), abs=0.1)


def test_where_all_can_be_halved_nothing_is_added():
    rest = Unhalved.of(np.ones(2), np.ones(2, dtype=bool), np.array([4, 4]))
    pooled = halves_of_noise(np.random.default_rng(0), [4, 4], 0.1)
    assert rest.halved == 1.0
    assert rest.noise(pooled) == 0
    assert rest.repeat(np.empty((0, N)), pooled, pooled) == (0, 0)
