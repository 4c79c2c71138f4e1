# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of a user's own sensor: lost samples are bridged, files that cannot be used are told."""

import re

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.headless.runs.own_sensor import read_pairs

N, RATE = 200, 50.0


@pytest.fixture
def worn():
    """A sensor whose six channels each change by a step of their own a sample."""
    ramps = np.arange(N)[:, None, None] * np.arange(1.0, 7.0)
    return ImuRecording(acc=ramps[..., :3].copy(), gyr=ramps[..., 3:].copy(), rate=RATE, sites=("wrist",))


def pairs_of(folder, recording):
    recording.save(folder / "waving.npz")
    return read_pairs([(folder / "waving.npz", folder / "waving.bvh")], lambda path, rate: (path.name, rate))


def test_lost_samples_are_on_the_line_between_their_neighbours(tmp_path, worn):
    whole = worn.acc.copy(), worn.gyr.copy()
    worn.acc[[50, 51, 52, 120]] = np.nan
    worn.gyr[7, 0, 1] = np.nan
    ((bridged, simulated),), left_out = pairs_of(tmp_path, worn)
    assert simulated == ("waving.bvh", RATE)
    assert not left_out
    np.testing.assert_allclose(bridged.acc, whole[0], rtol=1e-6)
    np.testing.assert_allclose(bridged.gyr, whole[1], rtol=1e-6)


def test_samples_lost_at_an_end_are_those_beside_them(tmp_path, worn):
    first, last = worn.acc[2, 0].copy(), worn.acc[-3, 0].copy()
    worn.acc[:2] = worn.acc[-2:] = np.nan
    (((bridged, _),), _) = pairs_of(tmp_path, worn)
    np.testing.assert_allclose(bridged.acc[:2, 0], [first] * 2, rtol=1e-6)
    np.testing.assert_allclose(bridged.acc[-2:, 0], [last] * 2, rtol=1e-6)


def test_a_recording_with_many_lost_samples_is_left_out_by_its_name(tmp_path, worn):
    worn.acc[:11] = np.nan
    with pytest.raises(ValueError, match=re.escape("waving.npz: 6 % of its samples are lost")):
        pairs_of(tmp_path, worn)
