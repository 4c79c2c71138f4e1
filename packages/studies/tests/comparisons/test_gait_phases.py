# SPDX-License-Identifier: GPL-3.0-or-later
"""Phases of a walk, taught by simulated sensors before and after a calibration on its other half."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w_studies.comparisons.gait_phases import PHASES, taught_phases

RATE, SECONDS, STEP_S = 50.0, 10, 1.0
WAYS = ["simulated, as it is", "simulated, turned to its angle", "simulated, and on its soft tissue", "worn"]


@pytest.fixture(scope="module")
def walk():
    """A site's simulated sensor, the worn one that sat half turned about, and the phases."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    turn = 2 * np.pi * time[:, None] / STEP_S
    acc = np.concatenate([3 * np.sin(turn), np.cos(2 * turn), 9.81 + 2 * np.sin(turn + 1)], axis=1)
    gyr = np.concatenate([2 * np.cos(turn), np.sin(turn), 0.5 * np.sin(2 * turn)], axis=1)
    noise = np.random.default_rng(0).normal(scale=0.05, size=(4, len(time), 3))
    sat = Rotation.from_euler("xyz", [170, 40, 0], degrees=True)
    made = ImuRecording((acc + noise[0])[:, None], (gyr + noise[1])[:, None], RATE, ("foot",))
    worn = [(sat.apply(signal) + extra)[:, None] for signal, extra in ((acc, noise[2]), (gyr, noise[3]))]
    phase = (time / STEP_S % 1 * len(PHASES)).astype(int)
    return [(ImuRecording(*worn, RATE, ("foot",)), made)], phase


def test_a_sensor_that_sat_otherwise_is_taught_once_its_turn_is_known(walk):
    found = taught_phases(*walk, longest_shift_s=0.1)
    assert [one.way for one in found] == WAYS
    f1 = {one.way: one.mean for one in found}
    assert f1["worn"] > 0.9
    assert f1["simulated, turned to its angle"] > 0.9
    assert f1["simulated, as it is"] < f1["simulated, turned to its angle"] - 0.2
    assert all(one.low <= one.mean <= one.high for one in found)
    assert all(one.by_site.shape == (1,) for one in found)
