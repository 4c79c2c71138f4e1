# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames that a converter wrote twice are bridged along the motion; a pose that is held is rest."""

import numpy as np
import pytest

from w2w.core.imu.trajectory import bridge

RATE = 120.0


def swing(n_frames=240):
    """Positions (3, T, 1) of a swing and its turn about x, as quaternions (4, T, 1)."""
    time = np.arange(n_frames) / RATE
    angle = 0.5 * np.sin(2 * np.pi * time)
    positions = np.stack([0 * time, np.sin(angle), -np.cos(angle)])[..., None]
    quaternions = np.stack([np.sin(angle / 2), 0 * time, 0 * time, np.cos(angle / 2)])[..., None]
    return positions, quaternions


def bridged(positions, quaternions):
    found = positions.copy(), quaternions.copy()
    bridge(*found, RATE, max_gap_s=0.2)
    return found


def test_frames_written_twice_are_read_from_the_motion_between_the_others():
    truth, frame = swing(241), np.arange(241)
    frame[3::2] -= 1  # 0 1 2 2 4 4 ... 240
    twice = [values[:, frame] for values in truth]
    for found, wanted, given in zip(bridged(*twice), truth, twice, strict=True):
        assert np.abs(given - wanted).max() > 0.01
        np.testing.assert_allclose(found, wanted, atol=1e-4)


@pytest.mark.parametrize("held_s", [0.15, 0.25])
def test_a_pose_that_is_held_between_two_movements_stays_held(held_s):
    frame = np.arange(240)
    frame[60:] = np.maximum(60, frame[60:] - round(held_s * RATE))
    given = [values[:, frame] for values in swing()]
    for found, held in zip(bridged(*given), given, strict=True):
        np.testing.assert_array_equal(found, held)


@pytest.mark.parametrize("part", [slice(None), slice(None, None, -1)], ids=["begins", "ends"])
def test_a_clip_that_begins_or_ends_at_rest_does(part):
    frame = np.maximum(0, np.arange(240) - 5)
    given = [values[:, frame][:, part] for values in swing()]
    for found, held in zip(bridged(*given), given, strict=True):
        np.testing.assert_array_equal(found, held)
