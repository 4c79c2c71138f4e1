# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings as files that other tools read, by the name of the format.

Text holds one sensor a file. Numbers are written with enough digits that reading them back gives the same
single-precision values.
"""

import json
from dataclasses import replace
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

CHANNELS = tuple(channel for reading in READINGS[:2] for channel in reading.channels)
"""Columns that a CSV must have."""

HELD = {"npz": tuple(FURTHER), "csv": tuple(FURTHER), "xsens": ("orientation",), "x-io": ("orientation",)}
"""Readings that each format holds beside acc and gyr."""


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
    channels = [channel for reading in recording.readings for channel in reading.channels]
    lines.append(",".join(("time_s", *channels)))
    write_text(path, "\n".join(lines) + "\n" + table_text(recording.time, values, ","))


def read_csv(path: str | Path, acc_unit: str | None = None, gyr_unit: str | None = None) -> ImuRecording:
    """Read one sensor from CSV with the columns of `write_csv`, in any order, among any others.

    Units are for files that do not name theirs. Raises ValueError if columns or units are missing, or the
    time stamps are not regular.
    """
    lines = text_lines(path)
    n_facts = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    facts = dict(parse_fact(line) for line in lines[:n_facts] if ":" in line)
    names = [name.strip() for name in lines[n_facts].split(",")] if n_facts < len(lines) else []
    missing = [name for name in ("time_s", *CHANNELS) if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    table = read_numbers(lines[n_facts + 1 :], ",", len(names), path)
    columns = {name: table[:, names.index(name)] for name in ("time_s", *CHANNELS)}
    acc_unit, gyr_unit = acc_unit or facts.get("acc_unit"), gyr_unit or facts.get("gyr_unit")
    if acc_unit is None or gyr_unit is None:
        raise ValueError(f"{path} does not name its units: say acc_unit and gyr_unit")
    values = np.stack([columns[name] for name in CHANNELS], axis=1)
    further = {
        reading.name: table[:, None, [names.index(channel) for channel in reading.channels]]
        for reading in READINGS[2:]
        if facts.get(f"{reading.name}_unit") == reading.unit and set(reading.channels) <= set(names)
    }
    return ImuRecording(
        acc=values[:, None, :3] * unit_factor(ACC_UNITS, acc_unit, "acc_unit"),
        gyr=values[:, None, 3:] * unit_factor(GYR_UNITS, gyr_unit, "gyr_unit"),
        rate=float(facts.get("rate_hz") or rate_of_stamps(columns["time_s"], path, 1e-6)),
        sites=(facts["site"],) if facts.get("site") else (),
        **{name: facts.get(name, "") for name in ("activity", "subject", "clip")},
        **further,
    )


FORMATS = ("npz", "csv", "xsens", "x-io")
"""W2W's own (all sensors), a table with units above it, MT Manager's text, an x-IMU3's folder."""


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
    kind = format or _format_of(Path(path))
    if kind == "npz":
        recording.save(path)
    elif kind == "csv":
        write_csv(path, recording, sensor)
    elif kind == "xsens":
        turned = recording.orientation
        write_xsens_txt(path, recording, sensor, None if turned is None else turned[:, sensor])
    elif kind == "x-io":
        write_x_io(path, recording, sensor)
    else:
        raise ValueError(f"no format is called {kind!r}; there are {', '.join(FORMATS)}")


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
    kind = format or _format_of(Path(path))
    readers = {"npz": ImuRecording.load, "csv": read_csv, "xsens": _read_xsens, "x-io": read_x_io}
    if kind not in readers:
        raise ValueError(f"no format is called {kind!r}; there are {', '.join(FORMATS)}")
    return readers[kind](path)


def _read_xsens(path: str | Path) -> ImuRecording:
    recording, quaternions = read_xsens_txt(path)
    return recording if quaternions is None else replace(recording, orientation=quaternions[:, None])


def _format_of(path: Path) -> str:
    """The format of a suffix."""
    kinds = {".npz": "npz", ".csv": "csv", ".txt": "xsens", "": "x-io"}
    suffix = "" if path.is_dir() else path.suffix.lower()
    if suffix not in kinds:
        raise ValueError(f"{path.name}: {suffix} stands for no format; name one of {', '.join(FORMATS)}")
    return kinds[suffix]
