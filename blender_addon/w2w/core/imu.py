# SPDX-License-Identifier: GPL-3.0-or-later
"""Ideal inertial signals of moving frames: specific force and angular velocity from world matrices."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from .filtering import count_resampled
from .recording import ImuRecording
from .rotations import continuous_quaternions
from .threads import n_threads
from .trajectory import MIN_FRAMES, spline_windows

STANDARD_GRAVITY = 9.80665
"""m/s2, by definition (CGPM 1901)."""

CHUNK_BYTES = 48 * 2**20
"""Working memory a chunk of sensors may take, about."""
BYTES_PER_POSE = 200


@dataclass(frozen=True)
class Synthesis:
    """How ideal signals are made from poses.

    Parameters
    ----------
    rate_hz : float
        Samples per second of the signals.
    method : {"spline", "finite-difference"}
    convention : {"physical", "paper"}
    cutoff_hz : float or None
        Band limit of the trajectories, -3 dB.
    gravity : tuple of 3 floats
        Acceleration of free fall in the world, m/s2.
    """

    rate_hz: float = 50.0
    method: str = "spline"
    convention: str = "physical"
    cutoff_hz: float | None = 10.0
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate_hz", float(self.rate_hz))
        if not (np.isfinite(self.rate_hz) and self.rate_hz > 0):
            raise ValueError(f"rate_hz must be positive, not {self.rate_hz}")
        if self.method != "spline":
            raise ValueError(f'method must be "spline", not {self.method!r}')
        if self.convention != "physical":
            raise ValueError(f'convention must be "physical", not {self.convention!r}')
        if self.cutoff_hz is not None and not (np.isfinite(self.cutoff_hz) and self.cutoff_hz > 0):
            raise ValueError(f"cutoff_hz must be positive, or None for no band limit, not {self.cutoff_hz}")
        gravity = tuple(float(g) for g in self.gravity)
        if len(gravity) != 3 or not np.isfinite(gravity).all():
            raise ValueError(f"gravity must be three finite numbers in m/s2, not {self.gravity}")
        object.__setattr__(self, "gravity", gravity)


def synthesize(matrices: np.ndarray, rate: float, settings: Synthesis | None = None) -> ImuRecording:
    """Ideal signals of sensors fixed to moving frames.

    Parameters
    ----------
    matrices : ndarray, shape (T, N, 4, 4)
        World matrix of every sensor in every frame: rotation sensor to world, position in metres.
    rate : float
        Frames per second.
    settings : Synthesis, optional

    Returns
    -------
    ImuRecording
        Specific force f = R^T (p'' - g), m/s2, and angular velocity in the sensor frame, rad/s.

    Raises
    ------
    ValueError
        If the shape is wrong, there are fewer than 3 frames, or a matrix is not a rigid motion.
    """
    settings = settings or Synthesis()
    if matrices.ndim != 4 or matrices.shape[2:] != (4, 4) or matrices.shape[1] == 0:
        raise ValueError(f"matrices must have shape (T, N, 4, 4), not {matrices.shape}")
    if not (np.isfinite(rate) and rate > 0):
        raise ValueError(f"the frame rate must be positive, not {rate}")
    n_frames, n_sensors = matrices.shape[:2]
    if n_frames < MIN_FRAMES:
        raise ValueError(f"a clip needs at least {MIN_FRAMES} frames to have an acceleration, not {n_frames}")
    n_samples = count_resampled(n_frames, rate, settings.rate_hz)
    acc = np.empty((n_samples, n_sensors, 3), dtype=np.float32)
    gyr = np.empty_like(acc)
    size = max(1, min(128, CHUNK_BYTES // (BYTES_PER_POSE * n_frames)))
    chunks = [slice(start, min(start + size, n_sensors)) for start in range(0, n_sensors, size)]

    def fill(chunk: slice) -> None:
        _spline_signals(matrices[:, chunk], rate, settings, acc[:, chunk], gyr[:, chunk])

    with ThreadPoolExecutor(n_threads()) as pool:
        list(pool.map(fill, chunks))
    return ImuRecording(acc=acc, gyr=gyr, rate=settings.rate_hz)


def _spline_signals(
    matrices: np.ndarray, rate: float, settings: Synthesis, acc: np.ndarray, gyr: np.ndarray
) -> None:
    """Fill `acc` and `gyr`, shape (samples, n, 3), from the matrices, shape (T, n, 4, 4)."""
    n_frames, n = matrices.shape[:2]
    positions = np.ascontiguousarray(matrices[:, :, :3, 3].transpose(0, 2, 1), dtype=np.float64)
    positions = positions.reshape(n_frames, 3 * n)
    quaternions = continuous_quaternions(matrices).reshape(n_frames, 4 * n)
    gravity = np.array(settings.gravity)[:, None]
    for window in spline_windows(n_frames, rate, settings.rate_hz, settings.cutoff_hz):
        value, first, second = window.operators
        shape = (len(value), -1, n)
        force = (second @ positions[window.frames]).reshape(shape) - gravity
        q = (value @ quaternions[window.frames]).reshape(shape).transpose(1, 0, 2)
        q_dot = (first @ quaternions[window.frames]).reshape(shape).transpose(1, 0, 2)
        scale = 2 / (q * q).sum(axis=0)
        into_sensor_frame(q, force.transpose(1, 0, 2), scale, acc[window.samples].transpose(2, 0, 1))
        angular_velocity(q, q_dot, scale, gyr[window.samples].transpose(2, 0, 1))


def into_sensor_frame(q: np.ndarray, v: np.ndarray, scale: np.ndarray, out: np.ndarray) -> None:
    """R^T v for quaternions of any length; `scale` is 2 / |q|^2. Component first: (4, ...), (3, ...)."""
    turned = _cross(q[1:], v)
    twice = _cross(q[1:], turned)
    for axis in range(3):
        out[axis] = v[axis] + scale * (twice[axis] - q[0] * turned[axis])


def angular_velocity(q: np.ndarray, q_dot: np.ndarray, scale: np.ndarray, out: np.ndarray) -> None:
    """Vector part of 2 q^-1 q', the rate in the sensor frame of the normalised quaternion."""
    turned = _cross(q[1:], q_dot[1:])
    for axis in range(3):
        out[axis] = scale * (q[0] * q_dot[1 + axis] - q_dot[0] * q[1 + axis] - turned[axis])


def _cross(a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
