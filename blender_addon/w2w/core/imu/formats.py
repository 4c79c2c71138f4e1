# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings as files that other tools read, by the name of the format.

Text holds one sensor a file. Numbers are written with enough digits that reading them back gives the same
single-precision values.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..given import given_path
from ..motion.motion import LABELS
from .phone_files import read_phone
from .recording import FURTHER, READINGS, ImuRecording
from .vendor_formats import (
    ACC_UNITS,
    GYR_UNITS,
    one_sensor,
    parse_fact,
    rate_of_stamps,
    read_table,
    read_x_io,
    read_xsens_txt,
    text_lines,
    unit_factor,
    write_table,
    write_x_io,
    write_xsens_txt,
)

COLUMNS = ("time_s", *(channel for reading in READINGS[:2] for channel in reading.channels))
"""Columns that a CSV must have."""

HELD = {"npz": tuple(FURTHER), "csv": tuple(FURTHER), "xsens": ("orientation",), "x-io": ("orientation",)}
"""Readings that each format holds besides acc and gyr.

W2W's own (all sensors), a table with units above it, MT Manager's text, an x-IMU3's folder.
"""

FORMATS = tuple(HELD)

PHONE = "phone"
"""What apps of phones and watches export, which is only read."""


def write_csv(
    path: str | Path,
    recording: ImuRecording,
    sensor: int = 0,
    acc_unit: str = "m/s2",
    gyr_unit: str = "rad/s",
) -> None:
    """Write one sensor as CSV: time_s, acc_x to acc_z, gyr_x to gyr_z, the units and labels above them.

    Further readings follow, by the names of `channels.READINGS` and in their units. The lines above the
    header start with ``#``: ``pandas.read_csv(path, comment="#")`` reads the rest.
    """
    readings = {reading.name: reading for reading in recording.readings}
    values = {name: getattr(recording, name)[:, sensor].astype(np.float64) for name in readings}
    values["acc"] /= unit_factor(ACC_UNITS, acc_unit, "acc_unit")
    values["gyr"] /= unit_factor(GYR_UNITS, gyr_unit, "gyr_unit")
    facts = {
        **{f"{name}_unit": reading.unit for name, reading in readings.items()},
        "acc_unit": acc_unit,
        "gyr_unit": gyr_unit,
        "rate_hz": recording.rate,
        "site": recording.sites[sensor] if recording.sites else "",
        **{name: getattr(recording, name) for name in LABELS},
    }
    lines = [f"# {name}: {json.dumps(value, ensure_ascii=False)}" for name, value in facts.items()]
    names = ["time_s", *(channel for reading in readings.values() for channel in reading.channels)]
    table = np.concatenate(list(values.values()), axis=1)
    write_table(path, lines, names, recording.time.tolist(), table, ",")


def read_csv(path: str | Path) -> ImuRecording:
    """Read one sensor from CSV with the columns of `write_csv`, in any order, among any others.

    Raises ValueError if columns or units are missing, or the time stamps are not regular.
    """
    lines = text_lines(path)
    n_facts = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    facts: dict[str, Any] = dict(parse_fact(line) for line in lines[:n_facts] if ":" in line)
    columns = read_table(lines[n_facts:], ",", COLUMNS, path)
    if not {"acc_unit", "gyr_unit"} <= facts.keys():
        raise ValueError(
            f"{path} does not name its units: begin it with lines such as '# acc_unit: m/s2' and "
            "'# gyr_unit: rad/s'"
        )
    further = [
        reading
        for reading in READINGS[2:]
        if facts.get(f"{reading.name}_unit") == reading.unit and set(reading.channels) <= set(columns)
    ]
    held: dict[str, Any] = {
        reading.name: one_sensor(columns, reading.channels) for reading in (*READINGS[:2], *further)
    }
    held["acc"] *= unit_factor(ACC_UNITS, facts["acc_unit"], "acc_unit")
    held["gyr"] *= unit_factor(GYR_UNITS, facts["gyr_unit"], "gyr_unit")
    return ImuRecording(
        rate=float(facts.get("rate_hz") or rate_of_stamps(columns["time_s"], path, 1e-6)),
        sites=(facts["site"],) if facts.get("site") else (),
        **held,
        **{name: facts.get(name, "") for name in LABELS},
    )


def write_recording(path: str | Path, recording: ImuRecording, format: str = "", sensor: int = 0) -> None:  # noqa: A002
    """Write a recording for another tool; what its format does not hold (`HELD`) is left out.

    Parameters
    ----------
    path : str or Path
        A file; for "x-io" a folder, made if needed.
    recording : ImuRecording
    format : {"npz", "csv", "xsens", "x-io"}
        By default that of the suffix: .npz, .csv, .txt (xsens), none (x-io).
    sensor : int
        Which of the recording's sensors, if the format holds one only.

    Raises
    ------
    ValueError
        If the format is unknown.

    Examples
    --------
    >>> at_rest = np.tile([0.0, 0.0, 9.81], (100, 1, 1))
    >>> recording = w2w.ImuRecording(at_rest, np.zeros((100, 1, 3)), rate=50.0)
    >>> w2w.write_recording("at_rest.csv", recording)
    >>> w2w.read_recording("at_rest.csv").rate
    50.0
    """
    if not isinstance(recording, ImuRecording):
        raise ValueError(f"write_recording takes a path, then an ImuRecording, not {recording!r}")
    kind = format_of(given_path(path, "a recording"), format)
    if kind == "npz":
        recording.save(path)
    else:
        writers: dict[str, Callable[[str | Path, ImuRecording, int], object]]
        writers = {"csv": write_csv, "xsens": write_xsens_txt, "x-io": write_x_io}
        writers[kind](path, recording, sensor)


def read_recording(path: str | Path, format: str = "") -> ImuRecording:  # noqa: A002
    """Read a recording in a format that `write_recording` writes, or that an app of a phone exports.

    Parameters
    ----------
    path : str or Path
        A file; for x-io and for an app that writes a file for each sensor, their folder.
    format : {"npz", "csv", "xsens", "x-io", "phone"}
        By default that of the suffix and of what the file looks like.

    Returns
    -------
    ImuRecording
        The sensors of the file.

    Raises
    ------
    ValueError
        If the format is unknown or the file does not hold it.

    Examples
    --------
    >>> at_rest = np.tile([0.0, 0.0, 9.81], (100, 1, 1))
    >>> recording = w2w.ImuRecording(at_rest, np.zeros((100, 1, 3)), rate=50.0)
    >>> w2w.write_recording("at_rest.csv", recording)
    >>> w2w.read_recording("at_rest.csv").rate
    50.0
    """
    path = given_path(path, "a recording")
    readers: dict[str, Callable[[Path], ImuRecording]]
    readers = {"npz": ImuRecording.load, "csv": read_csv, "xsens": read_xsens_txt, "x-io": read_x_io}
    return (readers | {PHONE: read_phone})[format_of(path, format, to_read=True)](path)


def format_of(path: Path, asked: str = "", to_read: bool = False) -> str:
    """The format asked for, or that of the suffix; to read, text that is nobody else's is a phone's."""
    known = (*FORMATS, PHONE) if to_read else FORMATS
    if asked in known:
        return asked
    if asked:
        raise ValueError(f"no format is called {asked!r}; there are {', '.join(known)}")
    if to_read and _is_phones(path):
        return PHONE
    kinds = {".npz": "npz", ".csv": "csv", ".txt": "xsens", "": "x-io"}
    suffix = "" if path.is_dir() else path.suffix.lower()
    if suffix not in kinds:
        raise ValueError(f"{path.name}: {suffix} stands for no format; name one of {', '.join(FORMATS)}")
    return kinds[suffix]


def _is_phones(path: Path) -> bool:
    """Whether a file or folder is neither W2W's nor a maker's."""
    if path.is_dir():
        return not (path / "Inertial.csv").is_file()
    if path.suffix.lower() not in (".csv", ".txt") or not path.is_file():
        return False
    with path.open("rb") as stream:
        start = stream.read(4096).lstrip(b"\xef\xbb\xbf")
    names = set(re.split(rb"[,\s]+", start))
    return not (re.match(rb"# ?\w+:|//", start) or {b"acc_x", b"time_s"} <= names)
