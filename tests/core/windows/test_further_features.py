# SPDX-License-Identifier: GPL-3.0-or-later
"""Features of what else is recorded tell what moves, and neither north nor the weather."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.features import further_features
from w2w.core.windows.windows import TooShortError, WindowSpec, cut_windows

RATE, SPEC = 50.0, WindowSpec(2.0, 1.0)


def recording(seconds=5.0, heading=0.0, sea_level=101325.0, swing=0.5, lift=0.2):
    """Two sensors that swing and rise."""
    time = np.arange(round(seconds * RATE)) / RATE
    still = np.tile([0, 0, 9.8], (len(time), 2, 1))
    turns = Rotation.from_rotvec([0, 0, heading]) * Rotation.from_rotvec(
        np.outer(swing * np.sin(3 * time), [1.0, 0, 0])
    )
    quaternions = np.repeat(turns.as_quat()[:, None, [3, 0, 1, 2]], 2, axis=1)
    pressure = np.repeat((sea_level - 12 * lift * np.sin(3 * time))[:, None, None], 2, axis=1)
    return ImuRecording(still, 0 * still, RATE, orientation=quaternions, barometer=pressure,
                        magnetometer=np.tile([20.0, 0, -40], (len(time), 2, 1)))  # fmt: skip


def test_their_windows_are_those_of_acc_and_gyr():
    for seconds in (0.8, 2.0, 5.3):
        made = recording(seconds)
        windows = cut_windows(made, SPEC)
        features = further_features(made, SPEC, ("orientation", "magnetometer", "barometer"))
        assert features.shape == (len(windows.is_test), 2, 5 * 6 + 5 * 4 + 4)
        assert np.isfinite(features).all()
    with pytest.raises(TooShortError):
        further_features(recording(0.2), SPEC, ("barometer",))


def test_neither_north_nor_weather_shows():
    one, other = recording(), recording(heading=2.0, sea_level=99000.0)
    for name in ("orientation", "barometer"):
        a, b = (further_features(made, SPEC, (name,)) for made in (one, other))
        np.testing.assert_allclose(a, b, atol=2e-2)


def test_swinging_and_rising_show():
    calm, lively = recording(swing=0.1, lift=0.05), recording(swing=0.9, lift=0.5)
    for name in ("orientation", "barometer"):
        a, b = (further_features(made, SPEC, (name,)) for made in (calm, lively))
        assert np.abs(a - b).max() > 0.5


def test_a_gap_costs_the_same_windows():
    made = recording()
    made.acc[120:140] = np.nan
    assert len(further_features(made, SPEC, ("barometer",))) == len(cut_windows(made, SPEC).is_test)


def test_a_short_gap_is_bridged_in_all_that_is_recorded():
    whole, lost = recording(), recording()
    for values in (lost.acc, lost.gyr, *lost.further.values()):
        values[120:123, 1] = np.nan
    names = ("orientation", "magnetometer", "barometer")
    found = further_features(lost, SPEC, names)
    np.testing.assert_allclose(found, further_features(whole, SPEC, names), atol=0.05)
