# SPDX-License-Identifier: GPL-3.0-or-later
"""Band limits that the output rate lowers, standard gravity, and rests that resampling leaves alone."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis
from w2w.core.parameters import parameters_of

from .test_synthesis import METHODS


def poses(positions, rotations=None):
    matrices = np.tile(np.eye(4), (len(positions), 1, 1, 1))
    matrices[:, 0, :3, 3] = positions
    if rotations is not None:
        matrices[:, 0, :3, :3] = rotations
    return matrices


def test_gravity_is_the_standard_one_and_points_up_in_a_sensor_at_rest():
    assert STANDARD_GRAVITY == 9.80665
    for method in METHODS:
        turned = Rotation.from_euler("xyz", [20, -35, 110], degrees=True).as_matrix()
        read = method(poses(np.zeros((60, 3)), turned), 30, Synthesis())
        np.testing.assert_allclose(
            read.acc[:, 0], np.tile(turned[2] * 9.80665, (len(read.acc), 1)), atol=1e-5
        )


@pytest.mark.parametrize(
    ("rate_hz", "cutoff_hz", "band"), [(50, 10, 10), (25, 10, 10), (20, 10, 8), (10, 10, 4), (100, 60, 40)]
)
def test_a_slow_sensor_lowers_the_band(rate_hz, cutoff_hz, band):
    assert Synthesis(rate_hz=rate_hz, cutoff_hz=cutoff_hz).band_hz == pytest.approx(band)
    assert Synthesis(rate_hz=rate_hz, cutoff_hz=None).band_hz is None


def test_no_band_limit_is_cautioned_of_wherever_the_band_is_set():
    assert Synthesis().caution == ""
    assert "motion above half the sensor rate is folded back" in Synthesis(cutoff_hz=None).caution
    assert "motion above half the sensor rate is then folded back" in parameters_of(Synthesis)["band"].help


@pytest.mark.parametrize("method", METHODS)
def test_what_would_fold_back_is_not_in_the_signal(method):
    """3.2 Hz, the band of a sensor at 8 Hz, is down to 0.71; 6 Hz, which would read as 2, to a twentieth."""
    frames = np.arange(1200) / 120
    for frequency, most, least in ((3.2, 0.75, 0.66), (6.0, 0.055, 0.0)):
        path = np.zeros((1200, 3))
        path[:, 0] = np.sin(2 * np.pi * frequency * frames) / (2 * np.pi * frequency) ** 2
        read = method(poses(path), 120, Synthesis(rate_hz=8, gravity=(0, 0, 0)))
        inner = read.acc[8:-8, 0, 0]
        assert least <= np.sqrt(2 * (inner**2).mean()) <= most


def test_resampling_a_rest_leaves_it_at_rest_to_both_ends():
    """The filter looks beyond the ends: there the sensor still stands, it does not fall freely."""
    acc = np.tile(np.float32([1.0, -2.0, 9.80665]), (240, 2, 1))
    still = ImuRecording(acc=acc, gyr=np.full_like(acc, 0.5), rate=120.0)
    for rate in (50.0, 100.0, 200.0):
        read = SensorModel(rate_hz=rate).apply(still, seed=0)
        np.testing.assert_allclose(read.acc, np.broadcast_to(acc[0], read.acc.shape), rtol=2e-3)
        np.testing.assert_allclose(read.gyr, 0.5, rtol=2e-3)


@pytest.mark.parametrize(
    ("n_samples", "rate", "new", "count"),
    [(101, 100, 50, 51), (100, 100, 50, 50), (120, 60, 50, 100), (120, 120, 100, 100), (3, 30, 50, 4)],
)
def test_the_last_sample_stands_on_or_before_the_last_frame(n_samples, rate, new, count):
    acc = np.zeros((n_samples, 1, 3), np.float32)
    read = SensorModel(rate_hz=new).apply(ImuRecording(acc=acc, gyr=acc, rate=float(rate)), 0)
    assert read.n_samples == count
    assert (count - 1) / new <= (n_samples - 1) / rate + 1e-9 < count / new + 1e-9
