# SPDX-License-Identifier: GPL-3.0-or-later
"""The ground under motions whose heights are known."""

import numpy as np
import pytest

from w2w.core.body.body import N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import on_the_ground

RATE = 30.0
DIP = np.concatenate([np.zeros(20), -0.1 * (1 - np.cos(np.linspace(0, 2 * np.pi, 60))), np.zeros(20)])
"""Heights of a body that sinks by 20 cm and comes back."""


def upright(body, heights, sideways=0.0):
    """The body in its rest pose, at heights (T,) and `sideways` (T,), metres."""
    place = np.stack([0 * heights + sideways, 0 * heights, heights], axis=1)
    return Motion(np.tile(np.eye(3), (len(heights), N_JOINTS, 1, 1)), body.joints[0] + place, RATE)


def found(body, motion):
    """Heights (T,) of an upright body over the ground that was found."""
    return on_the_ground(body, motion).pelvis[:, 2] - body.joints[0, 2]


def test_the_ground_is_where_the_body_stands_however_seldom_it_does(bundled_body):
    """In the air for nine frames of ten, and one frame of a hundred that fell through the floor."""
    rise = np.where(np.arange(100) % 10 == 0, 0.0, 0.8)
    rise[55] = -0.5
    np.testing.assert_allclose(found(bundled_body, upright(bundled_body, 3.0 + rise)), rise, atol=0.01)


@pytest.mark.parametrize("floor", [-1.0, 0.0, 2.0])
def test_a_body_that_sinks_and_comes_back_stands_at_its_ends_and_never_sinks(bundled_body, floor):
    stood = found(bundled_body, upright(bundled_body, floor + DIP))
    np.testing.assert_allclose(stood[[*range(8), *range(-8, 0)]], 0.0, atol=0.01)
    assert stood.min() > -0.01
    assert stood.max() < 0.1  # where it is lifted, before it would sink
    speed = np.diff(stood) * RATE
    assert abs(np.diff(speed) * RATE).max() < 9.81


@pytest.mark.parametrize(
    ("heights", "sideways"),
    [
        (DIP, np.linspace(0, 2, len(DIP))),  # walks down steps and up again
        (0.25 * np.linspace(0, 1, 100) ** 2, 0.0),  # ends higher than it began
        (np.abs(np.sin(np.linspace(0.5, 20, 100))), 0.0),  # begins in the air
        (DIP / 4, 0.0),
    ],
)
def test_other_motions_are_moved_as_a_whole(bundled_body, heights, sideways):
    motion = upright(bundled_body, heights, sideways)
    np.testing.assert_allclose(np.ptp(found(bundled_body, motion) - heights), 0, atol=1e-12)
