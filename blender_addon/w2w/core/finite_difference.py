# SPDX-License-Identifier: GPL-3.0-or-later
"""Inertial signals by finite differences, in the paper's order: difference, filter, resample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline

from .filtering import butterworth
from .rotations import double_inverse, into_frame, turn_between

if TYPE_CHECKING:
    from .imu import Synthesis

FILTER_ORDER = 4
"""Order of the zero-phase Butterworth filter."""


def difference_signals(
    positions: np.ndarray,
    quaternions: np.ndarray,
    rate: float,
    settings: Synthesis,
    acc: np.ndarray,
    gyr: np.ndarray,
) -> None:
    """Fill `acc` and `gyr`, shape (samples, n, 3), from differences between frames.

    Parameters
    ----------
    positions : ndarray, shape (3, T, n)
    quaternions : ndarray, shape (4, T, n)
        Sensor to world, continuous.
    rate : float
        Frames per second.
    settings : Synthesis
    acc, gyr : ndarray
        Where the signals go.

    Notes
    -----
    Physical: f = R^T (p'' - g) with the central second difference, omega = log(R(t-h)^T R(t+h)) / 2h. As
    the paper prints it: a + R^-1 g with a in the world frame, and log(R(t) R(t-h)^-1), here over h so that
    the unit is rad/s. The first and last frame have no central difference and take their neighbour's.
    """
    p, q = positions, quaternions
    acceleration = np.pad((p[:, 2:] - 2 * p[:, 1:-1] + p[:, :-2]) * rate**2, ((0, 0), (1, 1), (0, 0)), "edge")
    gravity = np.array(settings.gravity)[:, None, None]
    force = np.empty_like(acceleration)
    scale = double_inverse(q)
    if settings.convention == "physical":
        into_frame(q, scale, acceleration - gravity, force)
        spin = np.pad(turn_between(q[:, :-2], q[:, 2:]) * (rate / 2), ((0, 0), (1, 1), (0, 0)), "edge")
    else:
        into_frame(q, scale, np.broadcast_to(gravity, acceleration.shape), force)
        force += acceleration
        inverse = q * np.array([1, -1, -1, -1])[:, None, None]
        # q_k q_(k-1)^-1 is a^-1 b with a and b the inverses of q_k and q_(k-1)
        spin = np.pad(turn_between(inverse[:, 1:], inverse[:, :-1]) * rate, ((0, 0), (1, 0), (0, 0)), "edge")
    times = np.arange(len(acc)) / settings.rate_hz
    for values, out in ((force, acc), (spin, gyr)):
        out[:] = _band_limited(values, rate, settings.band_hz, times).transpose(1, 2, 0)


def _band_limited(values: np.ndarray, rate: float, cutoff_hz: float | None, times: np.ndarray) -> np.ndarray:
    """Filter at the clip's rate, then resample by cubic splines; (3, T, n) to (3, samples, n)."""
    if cutoff_hz is not None and cutoff_hz < rate / 2:
        filtered = butterworth(np.moveaxis(values, 1, -1), rate, cutoff_hz, FILTER_ORDER, zero_phase=True)
        values = np.moveaxis(filtered, -1, 1)
    return CubicSpline(np.arange(values.shape[1]) / rate, values, axis=1)(times)
