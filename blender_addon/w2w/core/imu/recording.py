# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording of one or more inertial sensors: its channels and their units, and its npz file."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..files import read_arrays, write_npz
from ..given import given_numbers
from ..motion.motion import LABELS
from ..wording import restated


@dataclass(frozen=True)
class Reading:
    """One of the things that a recording may hold."""

    name: str  # of the array in a recording
    title: str  # for people
    channels: tuple[str, ...]  # the numbers in a sample of it
    unit: str  # empty for numbers without one


READINGS = (
    Reading("acc", "Specific force", ("acc_x", "acc_y", "acc_z"), "m/s2"),
    Reading("gyr", "Angular velocity", ("gyr_x", "gyr_y", "gyr_z"), "rad/s"),
    Reading("orientation", "Orientation", ("quat_w", "quat_x", "quat_y", "quat_z"), ""),
    Reading("magnetometer", "Magnetic field", ("mag_x", "mag_y", "mag_z"), "uT"),
    Reading("barometer", "Pressure", ("pressure",), "Pa"),
)
"""All readings, in the order of every file; the first two are always there."""

FURTHER = {reading.name: len(reading.channels) for reading in READINGS[2:]}
"""Readings besides acc and gyr -> the numbers in a sample of each."""

FIELDS = ("acc", "gyr", "rate", "sites", *LABELS, *FURTHER)
MAX_BYTES = 8 * 2**30
"""No recording is larger; hours of hundreds of sensors are less."""


@dataclass(frozen=True, eq=False)
class ImuRecording:
    """Readings of accelerometers and gyroscopes, sensor by sensor, at one fixed rate.

    Parameters
    ----------
    acc : ndarray, shape (T, N, 3), float32
        Specific force in the sensor frame, m/s2: at rest +9.81 along "up". NaN marks a sample that was lost.
    gyr : ndarray, shape (T, N, 3), float32
        Angular velocity in the sensor frame, rad/s.
    rate : float
        Samples per second.
    sites : tuple of str
        Name of the place each sensor sits on; N of them, or none.
    activity, subject, clip : str
        Label, person and name of the clip; "" if unknown.
    orientation : ndarray, shape (T, N, 4), float32, optional
        Quaternions w, x, y, z from the sensor's frame to the clip's world.
    magnetometer : ndarray, shape (T, N, 3), float32, optional
        Magnetic field in the sensor's frame, microtesla.
    barometer : ndarray, shape (T, N, 1), float32, optional
        Pressure, Pa.

    Raises
    ------
    ValueError
        If shapes disagree, a value is infinite, or the rate is not positive.

    Examples
    --------
    >>> at_rest = np.tile([0.0, 0.0, 9.81], (100, 1, 1))
    >>> w2w.ImuRecording(at_rest, np.zeros((100, 1, 3)), rate=50.0, activity="resting", clip="on the desk")
    <ImuRecording 'on the desk', 'resting': 100 samples of 1 sensors at 50 Hz>
    """

    acc: np.ndarray
    gyr: np.ndarray
    rate: float
    sites: tuple[str, ...] = ()
    activity: str = ""
    subject: str = ""
    clip: str = ""
    orientation: np.ndarray | None = None
    magnetometer: np.ndarray | None = None
    barometer: np.ndarray | None = None

    def __repr__(self) -> str:
        shape = f"{self.n_samples} samples of {self.n_sensors} sensors at {self.rate:g} Hz"
        return f"<ImuRecording {self.clip!r}, {self.activity!r}: {shape}>"

    def __post_init__(self) -> None:
        for name in ("acc", "gyr", *self.further):
            values = given_numbers(getattr(self, name), name, np.float32)
            object.__setattr__(self, name, np.ascontiguousarray(values))
        with suppress(TypeError, ValueError):
            object.__setattr__(self, "rate", float(self.rate))
        object.__setattr__(self, "sites", tuple(self.sites))
        if self.acc.ndim != 3 or self.acc.shape[2] != 3 or 0 in self.acc.shape:
            raise ValueError(f"acc must have shape (T, N, 3), not {self.acc.shape}")
        if self.gyr.shape != self.acc.shape:
            raise ValueError(f"gyr must have the shape of acc, {self.acc.shape}, not {self.gyr.shape}")
        if np.isinf(self.acc).any() or np.isinf(self.gyr).any():
            raise ValueError("the recording holds infinite values")
        if not (isinstance(self.rate, float) and np.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"the sample rate must be positive, not {self.rate!r}")
        for name, array in self.further.items():
            wanted = (*self.acc.shape[:2], FURTHER[name])
            if array.shape != wanted or np.isinf(array).any():
                raise ValueError(f"{name} must have shape {wanted} and be finite, not {array.shape}")
        if self.sites and len(self.sites) != self.n_sensors:
            raise ValueError(f"sites must name all {self.n_sensors} sensors or none, not {len(self.sites)}")

    @property
    def further(self) -> dict[str, np.ndarray]:
        """The readings besides acc and gyr, by name."""
        held = {name: getattr(self, name) for name in FURTHER}
        return {name: array for name, array in held.items() if array is not None}

    @property
    def readings(self) -> tuple[Reading, ...]:
        """The readings that it holds, acc and gyr first."""
        return tuple(reading for reading in READINGS if getattr(self, reading.name) is not None)

    @property
    def values(self) -> np.ndarray:
        """All readings, shape (T, N, K), the channels in the order of `readings`."""
        return np.concatenate([getattr(self, reading.name) for reading in self.readings], axis=2)

    def at(self, sensors: Sequence[int]) -> Self:
        """The recording of some of its sensors."""
        chosen = list(sensors)
        arrays = {reading.name: getattr(self, reading.name)[:, chosen] for reading in self.readings}
        return replace(self, sites=tuple(self.sites[sensor] for sensor in chosen if self.sites), **arrays)

    def between(self, first: int, last: int) -> Self:
        """The recording of some of its samples."""
        return replace(self, **{one.name: getattr(self, one.name)[first:last] for one in self.readings})

    def with_sensors_of(self, other: Self) -> Self:
        """The recording with the sensors of another of the same motion after its own."""
        names = [reading.name for reading in self.readings]
        arrays = {name: np.concatenate([getattr(self, name), getattr(other, name)], axis=1) for name in names}
        return replace(self, sites=(*self.sites, *other.sites), **arrays)

    def labelled(self, sites: tuple[str, ...], activity: str, subject: str, clip: str) -> Self:
        """The recording under other labels."""
        return replace(self, sites=sites, activity=activity, subject=subject, clip=clip)

    @property
    def n_samples(self) -> int:
        """Number of samples in time, T."""
        return self.acc.shape[0]

    @property
    def n_sensors(self) -> int:
        """Number of sensors, N."""
        return self.acc.shape[1]

    @property
    def time(self) -> np.ndarray:
        """Seconds from the first sample, shape (T,), float64."""
        return np.arange(self.n_samples) / self.rate

    def save(self, path: str | Path) -> None:
        """Write the recording to an npz file, whole or not at all; equal recordings give equal bytes."""
        sites = np.array(self.sites, dtype=np.str_)
        labels = {name: np.array(getattr(self, name)) for name in LABELS}
        held = {"acc": self.acc, "gyr": self.gyr, "rate": np.array(self.rate), "sites": sites}
        write_npz(path, held | labels | self.further)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a recording that `save` wrote.

        Raises
        ------
        ValueError
            If the file is not a W2W recording.
        """
        with restated(f"{path} is not a W2W recording:", (ValueError, TypeError)):
            data = read_arrays(path, FIELDS, MAX_BYTES)
            missing = {"acc", "gyr", "rate"} - data.keys()
            if missing:
                raise ValueError(f"it lacks {', '.join(sorted(missing))}")
            given: dict[str, Any] = {name: str(data[name]) for name in LABELS if name in data}
            given |= {name: data[name] for name in ("acc", "gyr", *FURTHER) if name in data}
            if "sites" in data:
                given["sites"] = np.atleast_1d(data["sites"]).astype(str).tolist()
            return cls(rate=float(data["rate"].item()), **given)
