# SPDX-License-Identifier: GPL-3.0-or-later
"""What sensors read, channel by channel: the one list of names and units for files, tables and pictures."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Reading:
    """One of the things that a recording may hold.

    Parameters
    ----------
    name : str
        Of the array in a recording.
    title : str
        For people.
    channels : tuple of str
        The numbers in a sample of it.
    unit : str
        Empty for numbers without one.
    """

    name: str
    title: str
    channels: tuple[str, ...]
    unit: str


READINGS = (
    Reading("acc", "Specific force", ("acc_x", "acc_y", "acc_z"), "m/s2"),
    Reading("gyr", "Angular velocity", ("gyr_x", "gyr_y", "gyr_z"), "rad/s"),
    Reading("orientation", "Orientation", ("quat_w", "quat_x", "quat_y", "quat_z"), ""),
    Reading("magnetometer", "Magnetic field", ("mag_x", "mag_y", "mag_z"), "uT"),
    Reading("barometer", "Pressure", ("pressure",), "Pa"),
)
"""In the order that every file has them; the first two are always there."""

FURTHER = {reading.name: len(reading.channels) for reading in READINGS[2:]}
"""What else may be recorded -> the numbers in a sample of it."""
