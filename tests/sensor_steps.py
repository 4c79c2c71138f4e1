# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals by two roads, or of two processors: the same to one step of the sensor, not to the last bit."""

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel

STEPS = 1.01
"""Where a value lies between two steps, the last bit decides to which it is rounded."""

UNROUNDED = 1e-4
"""Steps of a sensor without rounding, m/s2 and rad/s."""

SELDOM = 0.01
"""Share of the samples that lie so where the same motion goes in; more are another signal."""


def assert_same_to_one_step(
    found: ImuRecording, expected: ImuRecording, sensor: SensorModel, seldom: float = SELDOM
) -> None:
    """Fail unless acceleration and turning are the same, but for single samples that are a step apart."""
    for name, triad in (("acc", sensor.accelerometer), ("gyr", sensor.gyroscope)):
        one, other, step = getattr(found, name), getattr(expected, name), triad.resolution or UNROUNDED
        np.testing.assert_allclose(one, other, rtol=0, atol=STEPS * step, err_msg=name)
        assert np.mean(np.abs(one - other) > step / 2) <= seldom, f"{name} differs in too many samples"
