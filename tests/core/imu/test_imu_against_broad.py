# SPDX-License-Identifier: GPL-3.0-or-later
"""Synthesis from a 60 Hz optical pose against the real IMU on the same body (BROAD)."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from w2w.core.filtering import butterworth
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w_studies.datasets.broad import BroadTrial, read_broad
from w2w_studies.experiments import broad
from w2w_studies.paper.differences import synthesize_by_differences

POSE_RATE = 60.0
LOWPASS_HZ = 10.0


@pytest.fixture(scope="module")
def trial(shared_data) -> BroadTrial:
    pytest.importorskip("h5py")
    return read_broad(shared_data / "imu" / "broad" / "07_undisturbed_fast_rotation_B.hdf5")


def agreement(
    trial: BroadTrial, settings: Synthesis, shift_s: float, method=synthesize
) -> tuple[float, float, float]:
    """Mean r of the three accelerometer axes, their RMSE, and mean r of the gyroscope's."""
    seen = np.isfinite(trial.matrices).all(axis=(1, 2, 3))
    stamps, matrices = trial.recording.time[seen], trial.matrices[seen, 0]
    times = np.arange(stamps[0], stamps[-1], 1 / POSE_RATE)
    pose = np.zeros((len(times), 1, 4, 4))
    pose[:, 0, :3, :3] = Slerp(stamps, Rotation.from_matrix(matrices[:, :3, :3]))(times).as_matrix()
    pose[:, 0, :3, 3] = CubicSpline(stamps, matrices[:, :3, 3])(times)
    pose[:, 0, 3, 3] = 1
    made = method(pose, POSE_RATE, settings)
    at = trial.recording.time[trial.movement]
    results = []
    for real, ideal in ((trial.recording.acc, made.acc), (trial.recording.gyr, made.gyr)):
        low_real = butterworth(real[:, 0].T.astype(float), trial.recording.rate, LOWPASS_HZ, 2, True).T
        low_made = butterworth(ideal[:, 0].T.astype(float), made.rate, LOWPASS_HZ, 2, True).T
        a, b = low_real[trial.movement], CubicSpline(times[0] + made.time, low_made)(at + shift_s)
        r = np.mean([np.corrcoef(a[:, axis], b[:, axis])[0, 1] for axis in range(3)])
        results += [r, np.sqrt(((a - b) ** 2).mean())]
    return results[0], results[1], results[2]


@pytest.mark.later
def test_it_reads_what_the_real_sensor_read(trial):
    """Nothing is fitted but the constant delay of the sensor against the optics."""
    acc_r, acc_rmse, gyr_r = agreement(trial, Synthesis(rate_hz=200, cutoff_hz=15), shift_s=-0.0042)
    assert acc_r >= 0.985
    assert acc_rmse <= 0.90
    assert gyr_r >= 0.998


@pytest.mark.later
def test_without_any_fit_it_is_still_close(trial):
    acc_r, acc_rmse, gyr_r = agreement(trial, Synthesis(rate_hz=200, cutoff_hz=15), shift_s=0.0)
    assert acc_r >= 0.985
    assert acc_rmse <= 0.90
    assert gyr_r >= 0.996


@pytest.mark.slow
def test_it_comes_closer_than_its_peers(trial):
    """With latency and lever arm out of the way, which hide the methods, and alike for all."""
    pytest.importorskip("imusim")
    times, pose = broad.pose_at(trial)
    methods = broad.methods(trial.recording.rate)
    ours, *peers = (
        broad.score(trial, methods[name](times, pose))["shifted, lever arm"]
        for name in ("W2W splines", "plain central differences", "x-io imusim 1.1.2")
    )
    for peer in peers:
        assert ours["acc_r"] > peer["acc_r"]
        assert ours["acc_rmse"] < peer["acc_rmse"]
        assert ours["gyr_r"] > peer["gyr_r"]


def test_the_printed_equations_are_not(trial):
    paper = Synthesis(rate_hz=60, convention="paper", cutoff_hz=None)
    acc_r, acc_rmse, gyr_r = agreement(trial, paper, 0.0, synthesize_by_differences)
    assert acc_r < 0.5
    assert acc_rmse > 5
    assert gyr_r < 0.5
