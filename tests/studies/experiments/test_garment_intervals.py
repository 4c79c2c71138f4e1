# SPDX-License-Identifier: GPL-3.0-or-later
"""Performers are drawn before their clips, and cloth that changes nothing leaves nothing to tell."""

import numpy as np
import pytest

from w2w.core.ranking.f1 import ClipUnits, f1_scores
from w2w.studies.experiments import garment_intervals

ACTIVITIES, PERFORMERS, CLIPS, PATCHES = 3, 4, 2, 6


def clips():
    """Performer and activity of each clip."""
    each = [
        (person, activity)
        for person in "abcd"[:PERFORMERS]
        for activity in range(ACTIVITIES)
        for _ in range(CLIPS)
    ]
    return np.array([one[0] for one in each]), np.array([one[1] for one in each])


def counted(seed, right):
    """Counts of two windows a clip at patches that are right so often."""
    rng = np.random.default_rng(seed)
    truth = np.repeat(clips()[1], 2)
    wrong = (truth[:, None] + rng.integers(1, ACTIVITIES, (len(truth), PATCHES))) % ACTIVITIES
    named = np.where(rng.random(wrong.shape) < right, truth[:, None], wrong)
    return ClipUnits(truth, np.repeat(np.arange(len(truth) // 2), 2), ACTIVITIES).count(named)


def drawn(resamples=4000):
    return garment_intervals.performers_and_clips(*clips(), resamples, np.random.default_rng(0))


def test_a_performer_drawn_brings_as_many_clips_of_each_activity_as_there_are():
    weights = drawn()
    performer, activity = clips()
    for person in np.unique(performer):
        by_activity = np.array(
            [weights[:, (performer == person) & (activity == a)].sum(axis=1) for a in range(ACTIVITIES)]
        )
        np.testing.assert_array_equal(by_activity, np.broadcast_to(by_activity[0], by_activity.shape))
        assert set(np.unique(by_activity)) <= set(CLIPS * np.arange(PERFORMERS + 1))
    np.testing.assert_array_equal(weights.sum(axis=1), len(performer))
    np.testing.assert_allclose(weights.mean(axis=0), 1, atol=0.1)


def test_of_one_clip_each_only_performers_vary():
    performer, activity = clips()
    once = np.arange(0, len(performer), CLIPS)
    rng = np.random.default_rng(0)
    weights = garment_intervals.performers_and_clips(performer[once], activity[once], 200, rng)
    for person in np.unique(performer):
        own = weights[:, performer[once] == person]
        np.testing.assert_array_equal(own, np.broadcast_to(own[:, :1], own.shape))


def test_halves_put_each_performer_on_one_side():
    performer, _ = clips()
    sides = garment_intervals.halves(performer)
    assert len(np.unique(sides, axis=0)) == 6
    for side in sides:
        assert not set(performer[side]) & set(performer[~side])
        assert len(set(performer[side])) == 2


def test_each_clip_once_gives_the_plain_figures():
    counts, every = counted(0, 0.7), np.ones((1, len(clips()[0])))
    plain = f1_scores(counts, every)[0].mean(axis=1)
    np.testing.assert_allclose(garment_intervals.mean_f1(counts, every)[0], plain, rtol=1e-6)
    rms = np.array([[3.0, 1.0, 2.0], [4.0, 1.0, 0.0]])
    assert garment_intervals.median_rms(rms, np.ones((1, 2)))[0] == pytest.approx(np.sqrt(2))
    assert garment_intervals.median_rms(rms, np.array([[2, 0]]))[0] == pytest.approx(2)


def test_an_interval_is_around_the_middle():
    low, high = garment_intervals.interval(np.append(np.linspace(0, 1, 1001), np.nan))
    assert (low, high) == (pytest.approx(0.025), pytest.approx(0.975))


def test_cloth_that_is_the_skin_agrees_with_it_as_the_skin_does_with_itself():
    counts = counted(0, np.linspace(0.3, 0.95, PATCHES))
    rho = garment_intervals.between_halves(counts, counts, garment_intervals.halves(clips()[0]))
    assert rho["skin by skin"] == pytest.approx(rho["cloth by cloth"]) == pytest.approx(rho["cloth by skin"])
    other = counted(0, np.linspace(0.95, 0.3, PATCHES))
    rho = garment_intervals.between_halves(counts, other, garment_intervals.halves(clips()[0]))
    assert rho["cloth by skin"] < 0 < min(rho["skin by skin"], rho["cloth by cloth"])
