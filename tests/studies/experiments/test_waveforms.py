# SPDX-License-Identifier: GPL-3.0-or-later
"""Of three real trials: what W2W makes of a movement goes with the worn sensors, and with OpenSim's."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.studies.experiments import waveforms


def test_walking_is_as_near_to_the_worn_sensors_as_opensims(shared_data):
    real, made, peer = waveforms.capsense(shared_data / "imu" / "capsense")
    kinds = ["acc", "gyr"]
    ours, theirs = (
        np.mean([waveforms.compared(real.at([k]), side.at([k]), kinds) for k in range(7)], axis=0)
        for side in (made, peer)
    )
    assert (ours[:, 2] > theirs[:, 2] - 0.01).all()
    assert (ours[:, 3] < theirs[:, 3] + 0.02).all()
    mirrored = ImuRecording(made.acc[::-1], made.gyr[::-1], made.rate, made.sites)
    wrong = waveforms.compared(real.at([0]), mirrored.at([0]), kinds)
    assert max(row[2] for row in wrong) < 0.6


def test_a_suits_own_sensors_turn_as_its_segments(shared_data):
    real, made = waveforms.mvnx(shared_data / "mvnx")
    legs = [k for k, site in enumerate(real.sites) if site.endswith(("Leg", "Foot"))]
    for k in legs:
        r, amplitude, axes, _ = waveforms.compared(real.at([k]), made.at([k]), ["acc", "gyr"])[1]
        assert min(r, axes) > 0.95
        assert 0.85 < amplitude < 1.1


@pytest.mark.slow
def test_jumps_are_compared_with_sensors_that_end_at_two_g(shared_data):
    pairs = waveforms.mhad(shared_data / "imu" / "berkeley_mhad")
    assert len(pairs) == 4
    hips = [waveforms.compared(a.at([k]), b.at([k]), ["acc"])[0] for a, b in pairs for k in (2, 3)]
    assert min(row[0] for row in hips) > 0.9
    assert max(np.abs(made.acc).max() for _, made in pairs) <= 2 * 9.81
