# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing a root path takes the jumps of a dead-reckoned one away and nothing else."""

import numpy as np
import pytest

from w2w.core.motion.motion import Motion, smoothed_root

RATE = 100.0


def walking(path):
    rotations = np.tile(np.eye(3), (len(path), 24, 1, 1))
    return Motion(rotations, path, RATE, activity="walk", subject="s", clip="c")


def acceleration(path):
    return np.diff(path, 2, axis=0) * RATE**2


def path_of(seconds=6.0):
    """Steady walking: forward speed with a bob and a sway."""
    t = np.arange(int(seconds * RATE)) / RATE
    return np.stack(
        [0.02 * np.sin(2 * np.pi * 0.9 * t), 1.3 * t, 0.95 + 0.02 * np.cos(2 * np.pi * 1.8 * t)], axis=1
    )


def test_jumps_of_millimetres_no_longer_shake_the_body():
    clean = path_of()
    jumps = np.zeros_like(clean)
    jumps[50::60, 0] = 0.004
    jumps[80::60, 0] = -0.004
    jumped = clean + np.cumsum(jumps, axis=0)
    before, after = (
        np.abs(acceleration(path) - acceleration(clean)).max()
        for path in (jumped, smoothed_root(walking(jumped), 3.0).pelvis)
    )
    assert before > 35  # m/s2: more than three times gravity from 4 mm
    assert after < before / 15


def test_walking_itself_passes():
    clean = path_of()
    smoothed = smoothed_root(walking(clean), 6.0).pelvis
    inner = slice(50, -50)
    np.testing.assert_allclose(smoothed[inner], clean[inner], atol=2e-4)


def test_all_else_stays():
    motion = walking(path_of(1.0))
    smoothed = smoothed_root(motion, 3.0)
    assert (smoothed.rotations == motion.rotations).all()
    assert (smoothed.rate, smoothed.activity, smoothed.subject, smoothed.clip) == (RATE, "walk", "s", "c")


@pytest.mark.parametrize("cutoff", [0.0, 50.0])
def test_a_cutoff_out_of_range_is_refused(cutoff):
    with pytest.raises(ValueError, match="between 0 and 50 Hz"):
        smoothed_root(walking(path_of(1.0)), cutoff)
