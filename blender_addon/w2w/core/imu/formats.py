# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings as files that other tools read, by the name of the format.

Text holds one sensor a file. Numbers are written with enough digits that reading them back gives the same
single-precision values.
"""

import json
from pathlib import Path

import numpy as np

from ..files import write_text
from .recording import FURTHER, READINGS, ImuRecording
from .text_tables import (
    ACC_UNITS,
    GYR_UNITS,
    parse_fact,
    rate_of_stamps,
    read_numbers,
    table_text,
    text_lines,
    unit_factor,
)
from .vendor_formats import read_x_io, read_xsens_txt, write_x_io, write_xsens_txt

COLUMNS = ("time_s", *(channel for reading in READINGS[:2] for channel in reading.channels))
"""Those that a CSV must have."""

HELD = {"npz": tuple(FURTHER), "csv": tuple(FURTHER), "xsens": ("orientation",), "x-io": ("orientation",)}
"""Readings that each format holds beside acc and gyr.

W2W's own (all sensors), a table with units above it, MT Manager's text, an x-IMU3's folder.
"""

FORMATS = tuple(HELD)


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
    values = np.concatenate(
        [
            recording.acc[:, sensor].astype(np.float64) / unit_factor(ACC_UNITS, acc_unit, "acc_unit"),
            recording.gyr[:, sensor].astype(np.float64) / unit_factor(GYR_UNITS, gyr_unit, "gyr_unit"),
            *(values[:, sensor].astype(np.float64) for values in recording.further.values()),
        ],
        axis=1,
    )
    facts = {
        "acc_unit": acc_unit,
        "gyr_unit": gyr_unit,
        **{f"{reading.name}_unit": reading.unit for reading in recording.readings[2:]},
        "rate_hz": recording.rate,
        "site": recording.sites[sensor] if recording.sites else "",
        "activity": recording.activity,
        "subject": recording.subject,
        "clip": recording.clip,
    }
    lines = [f"# {name}: {json.dumps(value, ensure_ascii=False)}" for name, value in facts.items()]
    lines.append(",".join(["time_s", *(name for reading in recording.readings for name in reading.channels)]))
    write_text(path, "\n".join(lines) + "\n" + table_text(recording.time.tolist(), values, ","))


def read_csv(path: str | Path, acc_unit: str | None = None, gyr_unit: str | None = None) -> ImuRecording:
    """Read one sensor from CSV with the columns of `write_csv`, in any order, among any others.

    Units are for files that do not name theirs. Raises ValueError if columns or units are missing, or the
    time stamps are not regular.
    """
    lines = text_lines(path)
    n_facts = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    facts = dict(parse_fact(line) for line in lines[:n_facts] if ":" in line)
    names = [name.strip() for name in lines[n_facts].split(",")] if n_facts < len(lines) else []
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    table = read_numbers(lines[n_facts + 1 :], ",", len(names), path)
    acc_unit, gyr_unit = acc_unit or facts.get("acc_unit"), gyr_unit or facts.get("gyr_unit")
    if acc_unit is None or gyr_unit is None:
        raise ValueError(f"{path} does not name its units: say acc_unit and gyr_unit")
    further = [
        reading
        for reading in READINGS[2:]
        if facts.get(f"{reading.name}_unit") == reading.unit and set(reading.channels) <= set(names)
    ]
    held = {
        reading.name: table[:, None, [names.index(channel) for channel in reading.channels]]
        for reading in (*READINGS[:2], *further)
    }
    held["acc"] *= unit_factor(ACC_UNITS, acc_unit, "acc_unit")
    held["gyr"] *= unit_factor(GYR_UNITS, gyr_unit, "gyr_unit")
    return ImuRecording(
        rate=float(facts.get("rate_hz") or rate_of_stamps(table[:, names.index("time_s")], path, 1e-6)),
        sites=(facts["site"],) if facts.get("site") else (),
        **{name: facts.get(name, "") for name in ("activity", "subject", "clip")},
        **held,
    )


def write_recording(path: str | Path, recording: ImuRecording, format: str = "", sensor: int = 0) -> None:  # noqa: A002
    """Write a recording for another tool; what its format does not hold (`HELD`) is left out.

    Parameters
    ----------
    path : str or Path
        A file; for "x-io" a folder, made if needed.
    recording : ImuRecording
    format : {"npz", "csv", "xsens", "x-io"}
        By default what the suffix says: .npz, .csv, .txt (xsens), none (x-io).
    sensor : int
        Which of the recording's sensors, where the format holds one.

    Raises
    ------
    ValueError
        If the format is unknown.
    """
    kind = _format_of(Path(path), format)
    if kind == "npz":
        recording.save(path)
    else:
        writers = {"csv": write_csv, "xsens": write_xsens_txt, "x-io": write_x_io}
        writers[kind](path, recording, sensor)


def read_recording(path: str | Path, format: str = "") -> ImuRecording:  # noqa: A002
    """Read a recording in a format that `write_recording` writes.

    Parameters
    ----------
    path : str or Path
    format : {"npz", "csv", "xsens", "x-io"}
        By default what the suffix says.

    Raises
    ------
    ValueError
        If the format is unknown or the file does not hold it.
    """
    readers = {"npz": ImuRecording.load, "csv": read_csv, "xsens": read_xsens_txt, "x-io": read_x_io}
    return readers[_format_of(Path(path), format)](path)


def _format_of(path: Path, asked: str) -> str:
    """The format asked for, or that of the suffix."""
    if asked in FORMATS:
        return asked
    if asked:
        raise ValueError(f"no format is called {asked!r}; there are {', '.join(FORMATS)}")
    kinds = {".npz": "npz", ".csv": "csv", ".txt": "xsens", "": "x-io"}
    suffix = "" if path.is_dir() else path.suffix.lower()
    if suffix not in kinds:
        raise ValueError(f"{path.name}: {suffix} stands for no format; name one of {', '.join(FORMATS)}")
    return kinds[suffix]
