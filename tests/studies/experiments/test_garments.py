# SPDX-License-Identifier: GPL-3.0-or-later
"""The angle to the vertical is read from specific force and angular velocity, however a sensor is pushed."""

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.studies.experiments.garments import tilts


def test_a_swinging_sensor_leans_as_it_swings():
    time = np.arange(1000) / 100
    angle = 0.4 * np.sin(2 * np.pi * time)
    push = 2.0 * np.sin(2 * np.pi * 3.1 * time)
    acc = np.stack([-9.81 * np.sin(angle) + push, 0 * time, 9.81 * np.cos(angle)], axis=1)[:, None]
    gyr = np.stack([0 * time, np.gradient(angle, time), 0 * time], axis=1)[:, None]
    found = tilts(ImuRecording(acc, gyr, 100.0))[0]
    assert abs(np.corrcoef(found, angle)[0, 1]) > 0.99
    assert abs(found.std() / angle.std() - 1) < 0.05
    felt = np.arctan2(acc[:, 0, 0], acc[:, 0, 2])  # the accelerometer alone is misled
    assert abs(np.corrcoef(felt, angle)[0, 1]) < 0.95
