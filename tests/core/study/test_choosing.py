# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a sensor may be turned is what tells its activities apart."""

import numpy as np
import pytest

from w2w.core.ranking.halves import CrossValidation
from w2w.core.study.choosing import FEWEST_OF_EACH, MOST_CLIPS, TURNS, _evenly, may_turn

RATE, CLIPS = 50.0, 12


def windows(*activities, seed=0):
    """Windows of clips, and their trainings: each activity is a function of time (T,) to acc (T, 3)."""
    rng = np.random.default_rng(seed)
    time = np.arange(100) / RATE
    signals, labels = [], []
    for activity, acc in enumerate(activities):
        for clip in range(CLIPS):
            gyr = 0.1 * rng.normal(size=(100, 3))
            signals.append(np.concatenate([acc(time) + 0.5 * rng.normal(size=(100, 3)), gyr], axis=1))
            labels.append((f"a{activity}", f"{activity} {clip}"))
    activity, clip = np.array(labels).T
    names = sorted(set(activity.tolist()))
    protocol = CrossValidation(activity, clip, None, np.ones(len(clip), bool), names)
    return np.array(signals, dtype=np.float32), protocol.plan(halvings=0)


def leaning(degrees):
    """At rest, gravity along a direction in the plane of the skin."""
    along = 9.8 * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    return lambda time: np.broadcast_to(along, (len(time), 3))


def swinging(along, hertz):
    return lambda time: 3.0 * np.sin(2 * np.pi * hertz * time)[:, None] * np.array(along) + [0, 0, 9.8]


@pytest.mark.parametrize(("apart", "least", "most"), [(20, 5, 10), (60, 20, 30), (180, 45, 90)])
def test_postures_may_turn_by_half_of_what_parts_them(apart, least, most):
    signals, planned = windows(leaning(0), leaning(apart))
    assert least <= may_turn(signals, RATE, planned, 0.02) <= most


def test_what_goes_along_the_normal_may_turn_as_it_likes():
    signals, planned = windows(swinging((0, 0, 1), 1.0), swinging((0, 0, 1), 2.5))
    assert may_turn(signals, RATE, planned, 0.02) == TURNS[-1]


def test_a_drop_that_is_allowed_lets_it_turn_further():
    signals, planned = windows(swinging((1, 0, 0), 1.5), swinging((0, 1, 0), 1.5))
    strict, lax = (may_turn(signals, RATE, planned, drop) for drop in (0.02, 1.0))
    assert strict < lax == TURNS[-1]


def test_few_clips_are_all_asked_and_many_evenly():
    chosen = np.array(_evenly(["rare"] * 3 + ["common"] * 5 * MOST_CLIPS))
    assert chosen[:3].tolist() == [0, 1, 2]
    assert set(np.diff(chosen[3:]).tolist()) <= {5, 6}
    assert len(chosen) == MOST_CLIPS


def test_of_each_of_many_activities_enough_clips_are_asked():
    chosen = np.array(_evenly([f"{n % 100}" for n in range(100 * MOST_CLIPS)]))
    assert np.bincount(chosen % 100).tolist() == [FEWEST_OF_EACH] * 100
