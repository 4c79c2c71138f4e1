# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistics of windows of what is recorded beside specific force and angular velocity.

None of them knows which way is north or what the weather is: those tell clips apart, not activities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ..imu.recording import ImuRecording
from .windows import WindowSpec, cut_alike

FLOOR = np.float32(0.0025)
"""Smallest change told apart, in units of each channel."""

EARTH_UT = 50.0
"""What counts as a middling magnetic field."""

PA_PER_M = 12.0
"""Pressure lost with each metre near the sea."""

STEADY = "barometer"
"""What tells nothing by its mean."""


def further_features(recording: ImuRecording, spec: WindowSpec, names: Sequence[str]) -> np.ndarray:
    """Describe each window of each sensor by what else was recorded.

    Parameters
    ----------
    recording : ImuRecording
        Holds what is named.
    spec : WindowSpec
    names : sequence of {"orientation", "magnetometer", "barometer"}

    Returns
    -------
    ndarray, shape (W, N, D), float32
        For each channel: mean, extremes about it, logarithms of the standard deviation and of the mean
        absolute derivative. Orientation has six channels, what points up in the sensor's frame and the turn
        since the window's middle; the magnetometer four, the field and its magnitude; the barometer one,
        the height about the window's mean, without a mean.
    """
    blocks = []
    for name in names:
        windows = cut_alike(recording.further[name], recording, spec)
        rows = [_statistics(_CHANNELS[name](window), recording.rate, name) for window in windows]
        blocks.append(np.stack(rows))
    return np.concatenate(blocks, axis=2)


def _statistics(channels: np.ndarray, rate: float, name: str) -> np.ndarray:
    """(N, k, samples) -> (N, D)."""
    mean = channels.mean(axis=2)
    centred = channels - mean[..., None]
    slope = np.abs(np.diff(channels, axis=2)).mean(axis=2) * (rate / 10)
    columns = [
        np.log(centred.std(axis=2) + FLOOR) / 1.5,
        np.arcsinh(centred.min(axis=2)),
        np.arcsinh(centred.max(axis=2)),
        np.log(slope + FLOOR) / 1.5,
    ]
    if name != STEADY:
        columns.insert(0, np.arcsinh(mean))
    return np.concatenate(columns, axis=1).astype(np.float32)


def _orientation(window: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4, samples) to (N, 6, samples): up in the sensor's frame, the turn since the middle."""
    n_sensors, _, samples = window.shape
    turned = Rotation.from_quat(window[:, [1, 2, 3, 0]].transpose(0, 2, 1).reshape(-1, 4))
    up = turned.inv().apply([0.0, 0.0, 1.0])
    middle = np.repeat(np.arange(n_sensors) * samples + samples // 2, samples)
    turn = (turned[middle].inv() * turned).as_rotvec()
    return np.concatenate([up, turn], axis=1).reshape(n_sensors, samples, 6).transpose(0, 2, 1)


def _magnetometer(window: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(window, axis=1, keepdims=True)
    return np.concatenate([window, length], axis=1) / EARTH_UT


def _barometer(window: np.ndarray) -> np.ndarray:
    pressure = window.astype(np.float64)
    return (pressure.mean(axis=2, keepdims=True) - pressure) / PA_PER_M


_CHANNELS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "orientation": _orientation,
    "magnetometer": _magnetometer,
    "barometer": _barometer,
}
