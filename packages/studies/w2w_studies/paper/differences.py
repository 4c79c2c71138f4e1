# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals by differences between frames, in the paper's order, to compare with the splines of the product."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from w2w.core.filtering import butterworth, count_resampled
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.trajectory import bridge
from w2w.core.rotations import decompose

FILTER_ORDER = 4
"""Order of the zero-phase Butterworth filter."""


def synthesize_by_differences(matrices: np.ndarray, rate: float, settings: Synthesis) -> ImuRecording:
    """Like `synthesize`, but take differences at the clip's rate, filter the signals, then resample them.

    Physical: f = R^T (p'' - g) with the central second difference, omega = log(R(t-h)^T R(t+h)) / 2h. As
    the paper prints it (equations 3 to 5): a + R^-1 g with a in the world frame, and log(R(t) R(t-h)^-1),
    here over h so that the unit is rad/s. The first and last frame have no central difference and take
    their neighbour's.
    """
    positions, quaternions = decompose(matrices, 0)
    bridge(positions, quaternions, rate, settings.max_gap_s, 0)
    p, q = np.moveaxis(positions, 0, -1), np.moveaxis(quaternions, 0, -1)
    turns = Rotation.from_quat(q.reshape(-1, 4), scalar_first=True).as_matrix().reshape(*p.shape, 3)
    back = np.swapaxes(turns, -2, -1)
    acceleration = _widened((p[2:] - 2 * p[1:-1] + p[:-2]) * rate**2, 1, 1)
    if settings.convention == "physical":
        force = np.einsum("tnij,tnj->tni", back, acceleration - settings.gravity)
        spin = _widened(_rotation_vectors(back[:-2] @ turns[2:]) * (rate / 2), 1, 1)
    else:
        force = acceleration + back @ settings.gravity
        spin = _widened(_rotation_vectors(turns[1:] @ back[:-1]) * rate, 1, 0)
    times = np.arange(count_resampled(len(p), rate, settings.rate_hz)) / settings.rate_hz
    acc, gyr = (_resampled(values, rate, times, settings.band_hz) for values in (force, spin))
    return ImuRecording(acc=acc, gyr=gyr, rate=settings.rate_hz)


def _rotation_vectors(turns: np.ndarray) -> np.ndarray:
    return Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(turns.shape[:-1])


def _widened(values: np.ndarray, before: int, after: int) -> np.ndarray:
    """Values (T, n, 3) with the first and the last frame repeated."""
    return np.pad(values, ((before, after), (0, 0), (0, 0)), "edge")


def _resampled(values: np.ndarray, rate: float, times: np.ndarray, band_hz: float | None) -> np.ndarray:
    """Values (T, n, 3) at `rate`, filtered and at other times, in single precision."""
    if band_hz is not None and band_hz < rate / 2:
        values = np.moveaxis(
            butterworth(np.moveaxis(values, 0, -1), rate, band_hz, FILTER_ORDER, zero_phase=True), -1, 0
        )
    return CubicSpline(np.arange(len(values)) / rate, values)(times).astype(np.float32)
