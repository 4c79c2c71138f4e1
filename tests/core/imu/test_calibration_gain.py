# SPDX-License-Identifier: GPL-3.0-or-later
"""A calibration's worth is told on what it was not fitted to."""

import numpy as np
import pytest

from w2w.core.imu.calibration import held_out

from .made_pairs import pair

pytestmark = pytest.mark.later


@pytest.mark.slow
def test_people_are_left_out_where_they_are_known():
    what, found = held_out([pair(seed=seed, subject=f"p{seed % 2}") for seed in range(4)])
    assert what == "person"
    assert len(found) == 4
    before, after = np.median([one.force for one in found], axis=0)
    assert after > 0.9 > 0.5 > before


@pytest.mark.slow
def test_recordings_are_left_out_otherwise():
    what, found = held_out([pair(seed=seed) for seed in range(2)])
    assert (what, len(found)) == ("recording", 2)
    assert all(one.turning[1] > 0.9 for one in found)


def test_a_single_recording_is_halved():
    what, found = held_out([pair(seconds=15, late_s=-0.1)])
    assert (what, len(found)) == ("half", 2)
    assert all(one.force[1] > 0.9 for one in found)


@pytest.mark.slow
def test_another_motion_is_not_made_alike():
    """A worn sensor that showed something else: no fit brings it near what is simulated."""
    pairs = [(pair(seed=seed)[0], pair(seed=seed + 10)[1]) for seed in range(3)]
    _, found = held_out(pairs)
    assert np.median([one.force for one in found], axis=0)[1] < 0.5
