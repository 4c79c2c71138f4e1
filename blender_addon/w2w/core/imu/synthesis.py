# SPDX-License-Identifier: GPL-3.0-or-later
"""Ideal inertial signals of moving frames: specific force and angular velocity from world matrices.

Conventions: the world has z up, gravity is g = (0, 0, -9.80665) m/s2 and R turns sensor to world. An
accelerometer reads the specific force f = R^T (p'' - g) and a gyroscope the angular velocity in the sensor
frame, the vee of R^T R'. At rest the sensor reads +9.81 along the axis that points up.
"""

from dataclasses import dataclass
from numbers import Real
from typing import Literal, Protocol

import numpy as np

from ..blas import multiply
from ..filtering import count_resampled
from ..parameters import parameter
from ..rotations import decompose, double_inverse, into_frame, rate_in_frame
from ..threads import chunks, for_each
from .recording import ImuRecording
from .trajectory import MIN_FRAMES, bridge, spline_windows

STANDARD_GRAVITY = 9.80665
"""m/s2, by definition (CGPM 1901)."""

LARGEST_BAND = 0.4
"""Highest band limit over the sample rate: what lies above would fold back into the signal."""

FOLDED_BACK = "without a band limit (band 0), motion above half the sensor rate is folded back (aliasing)"
"""The caution on signals that are made without a band limit."""

CHUNK_SENSORS = 256
CHUNK_BYTES = 192 * 2**20
BYTES_PER_POSE = 400
"""Most sensors of a chunk, and bytes that a long clip may take, with fewer sensors."""


CONVENTIONS: tuple[Literal["physical", "paper"], ...] = ("physical", "paper")


@dataclass(frozen=True)
class Synthesis:
    """How ideal signals are made from poses.

    Parameters
    ----------
    rate_hz : float
        Samples per second of the signals, any.
    convention : {"physical", "paper"}
        "paper" gives equations 3 to 5 as printed, in the world frame and with gravity the wrong way; for
        comparison only.
    cutoff_hz : float or None
        Band limit of the trajectories, -3 dB. It keeps the jitter of motion capture out and is lowered to
        0.4 `rate_hz` if it would exceed that. None sets no limit: the splines pass through every frame,
        and motion above half of `rate_hz` is folded back (aliasing).
    gravity : tuple of 3 floats
        Acceleration of free fall in the world, m/s2.
    max_gap_s : float
        Longest run of frames without a pose (NaN) that is bridged, s.

    Raises
    ------
    ValueError
        If a parameter is out of its range; the message names it.

    Examples
    --------
    >>> w2w.Synthesis(rate_hz=100.0, cutoff_hz=20.0).rate_hz
    100.0
    """

    rate_hz: float = parameter(
        50.0,
        "Sensor rate, Hz: samples a second.",
        "rate",
        title="Rate", unit="Hz", least=5, most=1000, usual=(10, 200), panel="signals",
    )  # fmt: skip
    convention: Literal["physical", "paper"] = parameter(
        "physical",
        "How specific force and angular velocity are defined: physical, or paper (the equations as the "
        "paper prints them, for comparison only).",
        title="Convention", group="Signals",
    )  # fmt: skip
    cutoff_hz: float | None = parameter(
        10.0,
        "Band limit of the paths, Hz; raise it for clean motion capture. 0 for none: motion above half the "
        "sensor rate is then folded back (aliasing).",
        "band",
        title="Band", unit="Hz", least=0, most=1000, usual=(None, 40), group="Signals", panel="bands",
    )  # fmt: skip
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)
    max_gap_s: float = 0.25

    def __post_init__(self) -> None:
        if not (isinstance(self.rate_hz, Real) and np.isfinite(self.rate_hz) and self.rate_hz > 0):
            raise ValueError(f"rate_hz must be a positive number, not {self.rate_hz!r}")
        if self.convention not in CONVENTIONS:
            raise ValueError(f'convention must be "physical" or "paper", not {self.convention!r}')
        if self.cutoff_hz is not None and not (
            isinstance(self.cutoff_hz, Real) and np.isfinite(self.cutoff_hz) and self.cutoff_hz > 0
        ):
            raise ValueError(f"cutoff_hz must be positive, or None for no limit, not {self.cutoff_hz!r}")
        gravity = tuple(float(g) for g in self.gravity)
        if len(gravity) != 3 or not np.isfinite(gravity).all():
            raise ValueError(f"gravity must be three finite numbers in m/s2, not {self.gravity}")
        object.__setattr__(self, "gravity", gravity)
        if not (np.isfinite(self.max_gap_s) and self.max_gap_s >= 0):
            raise ValueError(f"max_gap_s must be 0 or more, not {self.max_gap_s}")

    @property
    def band_hz(self) -> float | None:
        """The band limit in force, Hz."""
        return None if self.cutoff_hz is None else min(self.cutoff_hz, LARGEST_BAND * self.rate_hz)

    @property
    def caution(self) -> str:
        """A caution on signals without a band limit; "" if there is a limit."""
        return "" if self.cutoff_hz else FOLDED_BACK


class Poses(Protocol):
    """World matrices to be read in parts: an ndarray, a memory map, or made when asked for."""

    @property
    def shape(self) -> tuple[int, ...]:
        """T, N, 4, 4."""

    def __getitem__(self, part: tuple[slice, slice]) -> np.ndarray:
        """Matrices of all frames and a range of sensors."""


def synthesize(matrices: Poses, rate: float, settings: Synthesis = Synthesis()) -> ImuRecording:
    """Ideal signals of sensors fixed to moving frames, at `settings.rate_hz` and without labels.

    `matrices` (T, N, 4, 4), or anything that slices like it, are each sensor's world matrix in each frame:
    rotation sensor to world, position in metres; NaN marks a missing pose. `rate` is in frames per second.

    Raises ValueError if the shape is wrong, there are fewer than 3 frames, a gap is too long to bridge, or a
    matrix is not a rigid motion.
    """
    if len(matrices.shape) != 4 or matrices.shape[2:] != (4, 4) or matrices.shape[1] == 0:
        raise ValueError(f"matrices must have shape (T, N, 4, 4), not {matrices.shape}")
    if not (np.isfinite(rate) and rate > 0):
        raise ValueError(f"the frame rate must be positive, not {rate}")
    n_frames, n_sensors = matrices.shape[:2]
    if n_frames < MIN_FRAMES:
        raise ValueError(f"a clip needs at least {MIN_FRAMES} frames to have an acceleration, not {n_frames}")
    n_samples = count_resampled(n_frames, rate, settings.rate_hz)
    acc = np.empty((n_samples, n_sensors, 3), dtype=np.float32)
    gyr = np.empty_like(acc)
    size = max(1, min(CHUNK_SENSORS, CHUNK_BYTES // (BYTES_PER_POSE * n_frames)))

    def fill(chunk: slice) -> None:
        positions, quaternions = decompose(matrices[:, chunk], chunk.start)
        bridge(positions, quaternions, rate, settings.max_gap_s, chunk.start)
        _fill(positions, quaternions, rate, settings, acc[:, chunk], gyr[:, chunk])

    for_each(fill, chunks(n_sensors, size))
    return ImuRecording(acc=acc, gyr=gyr, rate=settings.rate_hz)


def _fill(
    p: np.ndarray, q: np.ndarray, rate: float, settings: Synthesis, acc: np.ndarray, gyr: np.ndarray
) -> None:
    """Fill `acc` and `gyr`, shape (samples, n, 3), from splines through poses at `rate`.

    Positions p are (3, T, n), continuous quaternions q (4, T, n) turn sensor to world. The rotation follows
    a quintic spline of the quaternion's components, normalised: as smooth on the rotation group as the
    spline is. Differences are taken in double precision, all else in single.
    """
    bend = _steps(np.diff(p, axis=1))
    steps = _steps(q)
    frames = q.astype(np.float32)
    gravity = np.array(settings.gravity, dtype=np.float32)[:, None, None]
    for window in spline_windows(p.shape[1], rate, settings.rate_hz, settings.band_hz):
        value, first, second = window.operators
        start, stop = window.frames.start, window.frames.stop
        acceleration = multiply(second, bend[:, start : stop - 2])
        q = multiply(value, frames[:, start:stop])
        q_dot = multiply(first, steps[:, start : stop - 1])
        scale = double_inverse(q)
        acc_out, gyr_out = (out[window.samples].transpose(2, 0, 1) for out in (acc, gyr))
        if settings.convention == "physical":
            acceleration -= gravity
            into_frame(q, scale, acceleration, acc_out)
            rate_in_frame(q, scale, q_dot, gyr_out)
        else:
            into_frame(q, scale, np.broadcast_to(gravity, acceleration.shape), acc_out)
            acc_out += acceleration
            # the rate in the world frame is the sensor frame's of the inverse quaternion, turned over
            inverse = np.array([1, -1, -1, -1], dtype=np.float32)[:, None, None]
            rate_in_frame(q * inverse, scale, q_dot * -inverse, gyr_out)


def _steps(values: np.ndarray) -> np.ndarray:
    """Differences along axis 1, taken in double and kept in single precision."""
    steps = np.empty((values.shape[0], values.shape[1] - 1, values.shape[2]), dtype=np.float32)
    return np.subtract(values[:, 1:], values[:, :-1], out=steps, casting="same_kind")
