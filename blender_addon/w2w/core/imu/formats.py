# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings as text that other tools read: CSV, Xsens text, x-io CSV and OpenSim orientations.

Text holds one sensor a file, except OpenSim's. Numbers are written with enough digits that reading them back
gives the same single-precision values.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from ..files import write_text
from .recording import ImuRecording

ACC_UNITS = {"m/s2": 1.0, "g": 9.80665}
"""Units of specific force, in m/s2."""

GYR_UNITS = {"rad/s": 1.0, "deg/s": np.pi / 180}
"""Units of angular velocity, in rad/s."""

CHANNELS = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")

XSENS_COLUMNS = ("PacketCounter", "SampleTimeFine", "Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z")
XSENS_TICKS = 10_000
"""Ticks of SampleTimeFine in a second (Xsens MT0101P, timestamp output)."""

X_IO_HEADER = (
    "Timestamp (us),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),"
    "Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)"
)

REGULARITY = 0.1
"""Largest deviation of a time stamp from a regular grid, in sample intervals."""


def write_csv(
    path: str | Path,
    recording: ImuRecording,
    sensor: int = 0,
    acc_unit: str = "m/s2",
    gyr_unit: str = "rad/s",
) -> None:
    """Write one sensor as CSV: time_s, acc_x to acc_z, gyr_x to gyr_z, the units and labels above them.

    The lines above the header start with ``#``: ``pandas.read_csv(path, comment="#")`` reads the rest.

    Parameters
    ----------
    path : str or Path
    recording : ImuRecording
    sensor : int
        Which of the recording's sensors.
    acc_unit : {"m/s2", "g"}
    gyr_unit : {"rad/s", "deg/s"}
    """
    values = np.concatenate(
        [
            recording.acc[:, sensor].astype(np.float64) / _unit(ACC_UNITS, acc_unit, "acc_unit"),
            recording.gyr[:, sensor].astype(np.float64) / _unit(GYR_UNITS, gyr_unit, "gyr_unit"),
        ],
        axis=1,
    )
    facts = {
        "acc_unit": acc_unit,
        "gyr_unit": gyr_unit,
        "rate_hz": recording.rate,
        "site": recording.sites[sensor] if recording.sites else "",
        "activity": recording.activity,
        "subject": recording.subject,
        "clip": recording.clip,
    }
    lines = [f"# {name}: {json.dumps(value, ensure_ascii=False)}" for name, value in facts.items()]
    lines.append(",".join(("time_s", *CHANNELS)))
    write_text(path, "\n".join(lines) + "\n" + _rows(recording.time, values, ","))


def read_csv(path: str | Path, acc_unit: str | None = None, gyr_unit: str | None = None) -> ImuRecording:
    """Read one sensor from CSV with the columns of `write_csv`, in any order, among any others.

    Parameters
    ----------
    path : str or Path
    acc_unit, gyr_unit : str, optional
        Units, for files that do not name theirs.

    Raises
    ------
    ValueError
        If columns or units are missing, or the time stamps are not regular.
    """
    lines = _lines(path)
    n_facts = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    facts = dict(_fact(line) for line in lines[:n_facts] if ":" in line)
    names = [name.strip() for name in lines[n_facts].split(",")] if n_facts < len(lines) else []
    missing = [name for name in ("time_s", *CHANNELS) if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    table = _table(lines[n_facts + 1 :], ",", len(names), path)
    columns = {name: table[:, names.index(name)] for name in ("time_s", *CHANNELS)}
    acc_unit, gyr_unit = acc_unit or facts.get("acc_unit"), gyr_unit or facts.get("gyr_unit")
    if acc_unit is None or gyr_unit is None:
        raise ValueError(f"{path} does not name its units: say acc_unit and gyr_unit")
    values = np.stack([columns[name] for name in CHANNELS], axis=1)
    return ImuRecording(
        acc=values[:, None, :3] * _unit(ACC_UNITS, acc_unit, "acc_unit"),
        gyr=values[:, None, 3:] * _unit(GYR_UNITS, gyr_unit, "gyr_unit"),
        rate=float(facts.get("rate_hz") or _rate_of(columns["time_s"], path, 1e-6)),
        sites=(facts["site"],) if facts.get("site") else (),
        **{name: facts.get(name, "") for name in ("activity", "subject", "clip")},
    )


def write_xsens_txt(
    path: str | Path, recording: ImuRecording, sensor: int = 0, quaternions: np.ndarray | None = None
) -> None:
    """Write one sensor as MT Manager exports it: m/s2, rad/s, tab-separated under ``//`` lines.

    Parameters
    ----------
    path : str or Path
        OpenSim expects ``<trial prefix><sensor name>.txt``.
    recording : ImuRecording
    sensor : int
        Which of the recording's sensors.
    quaternions : ndarray, shape (T, 4), optional
        Orientation w, x, y, z, sensor to world.
    """
    names = XSENS_COLUMNS
    values = np.concatenate([recording.acc[:, sensor], recording.gyr[:, sensor]], axis=1)
    if quaternions is not None:
        names = (*names, "Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3")
        values = np.concatenate([values, quaternions], axis=1)
    head = [
        "// Start Time: Unknown",
        f"// Update Rate: {recording.rate!r}Hz",
        "// Filter Profile: none",
        "// Option Flags: none",
        "// Firmware Version: W2W",
    ]
    counter = np.arange(recording.n_samples)
    ticks = np.rint(recording.time * XSENS_TICKS).astype(np.int64)
    rows = "".join(
        "\t".join([str(count), str(tick), *map(_shortest, row)]) + "\n"
        for count, tick, row in zip(counter, ticks, values.tolist(), strict=True)
    )
    write_text(path, "\n".join(head) + "\n" + "\t".join(names) + "\n" + rows)


def read_xsens_txt(path: str | Path) -> tuple[ImuRecording, np.ndarray | None]:
    """Read one sensor from an MT Manager export.

    Returns
    -------
    recording : ImuRecording
    quaternions : ndarray, shape (T, 4), or None
        Orientation w, x, y, z, sensor to world, where the file has one.

    Raises
    ------
    ValueError
        If a column of the acceleration or rate of turn is missing, or no rate is given.
    """
    lines = _lines(path)
    head = [line for line in lines if line.startswith("//")]
    rate = next((line.split(":", 1)[1] for line in head if "Update Rate" in line), None)
    if rate is None:
        raise ValueError(f"{path} is no MT Manager export: it has no line '// Update Rate:'")
    body = [line for line in lines[len(head) :] if line]
    names = body[0].split("\t") if body else []
    missing = [name for name in XSENS_COLUMNS[2:] if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    table = _table(body[1:], "\t", len(names), path)
    values = table[:, [names.index(name) for name in XSENS_COLUMNS[2:]]]
    quaternion_names = [f"Quat_q{k}" for k in range(4)]
    quaternions = None
    if set(quaternion_names) <= set(names):
        quaternions = table[:, [names.index(name) for name in quaternion_names]]
    recording = ImuRecording(
        acc=values[:, None, :3], gyr=values[:, None, 3:], rate=float(rate.strip().removesuffix("Hz"))
    )
    return recording, quaternions


def write_x_io(folder: str | Path, recording: ImuRecording, sensor: int = 0) -> None:
    """Write one sensor as x-io's x-IMU3 logs it: ``Inertial.csv`` in a folder, g, deg/s and microseconds.

    Parameters
    ----------
    folder : str or Path
        Folder of the device; made if needed.
    recording : ImuRecording
    sensor : int
        Which of the recording's sensors.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    values = np.concatenate(
        [
            recording.gyr[:, sensor].astype(np.float64) / GYR_UNITS["deg/s"],
            recording.acc[:, sensor].astype(np.float64) / ACC_UNITS["g"],
        ],
        axis=1,
    )
    stamps = np.rint(recording.time * 1e6).astype(np.int64)
    write_text(Path(folder) / "Inertial.csv", X_IO_HEADER + "\n" + _rows(stamps, values, ","))


def read_x_io(folder: str | Path) -> ImuRecording:
    """Read one sensor from the folder of an x-IMU3.

    Raises
    ------
    ValueError
        If there is no ``Inertial.csv`` with x-io's header, or its time stamps are not regular.
    """
    path = Path(folder) / "Inertial.csv"
    if not path.is_file():
        raise ValueError(f"{folder} is no x-IMU3 log: it has no Inertial.csv")
    lines = _lines(path)
    if not lines or lines[0].strip() != X_IO_HEADER:
        raise ValueError(f"{path} does not start with x-io's header, {X_IO_HEADER}")
    table = _table(lines[1:], ",", 7, path)
    return ImuRecording(
        acc=table[:, None, 4:] * ACC_UNITS["g"],
        gyr=table[:, None, 1:4] * GYR_UNITS["deg/s"],
        rate=_rate_of(table[:, 0] / 1e6, path, 1e-6),
    )


def write_orientation_sto(
    path: str | Path, quaternions: np.ndarray, rate: float, sites: tuple[str, ...]
) -> None:
    """Write orientations as OpenSense reads them.

    The world keeps its z axis up: give OpenSense ``sensor_to_opensim_rotations`` of (-pi/2, 0, 0), as for
    Xsens, to turn it to OpenSim's y axis.

    Parameters
    ----------
    path : str or Path
    quaternions : ndarray, shape (T, N, 4)
        w, x, y, z, sensor to world.
    rate : float
        Samples per second.
    sites : tuple of str
        Names of the N sensors, without tabs; OpenSense looks for ``<body>_imu``.
    """
    quaternions = np.asarray(quaternions, dtype=np.float64)
    if quaternions.ndim != 3 or quaternions.shape[1:] != (len(sites), 4):
        raise ValueError(
            f"quaternions must have shape (T, {len(sites)}, 4), one a site, not {quaternions.shape}"
        )
    if any(set("\t\r\n") & set(site) for site in sites):
        raise ValueError(f"names of sites may hold no tabs or line ends: {sites}")
    head = [f"DataRate={rate!r}", "DataType=Quaternion", "version=3", "OpenSimVersion=4.5", "endheader"]
    head.append("\t".join(("time", *sites)))
    rows = (
        "\t".join([repr(k / rate), *(",".join(map(repr, q)) for q in row)])
        for k, row in enumerate(quaternions.tolist())
    )
    write_text(path, "\n".join([*head, *rows]) + "\n")


def read_orientation_sto(path: str | Path) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Read orientations from an OpenSim storage file.

    Returns
    -------
    quaternions : ndarray, shape (T, N, 4)
        w, x, y, z.
    rate : float
        Samples per second.
    sites : tuple of str

    Raises
    ------
    ValueError
        If the file holds no quaternions.
    """
    lines = _lines(path)
    if "endheader" not in lines:
        raise ValueError(f"{path} is no OpenSim storage file: it has no line 'endheader'")
    start = lines.index("endheader")
    facts = dict(line.split("=", 1) for line in lines[:start] if "=" in line)
    if facts.get("DataType") != "Quaternion":
        raise ValueError(f"{path} holds {facts.get('DataType', 'numbers')}, not quaternions")
    sites = tuple(lines[start + 1].split("\t")[1:])
    fields = [line.split("\t") for line in lines[start + 2 :] if line]
    try:
        quaternions = np.array([[field.split(",") for field in row[1:]] for row in fields], dtype=np.float64)
        stamps = np.array([row[0] for row in fields], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"{path} has a row that does not hold {len(sites)} quaternions") from error
    if quaternions.shape != (len(fields), len(sites), 4):
        raise ValueError(f"{path} has rows that do not hold {len(sites)} quaternions")
    rate = float(facts["DataRate"]) if "DataRate" in facts else _rate_of(stamps, path, 1e-6)
    return quaternions, rate, sites


def _lines(path: str | Path) -> list[str]:
    """Lines of a UTF-8 text, ended by line feeds alone: labels may hold other separators."""
    return Path(path).read_text(encoding="utf-8-sig").rstrip("\n").split("\n")


def _unit(units: dict[str, float], unit: str, name: str) -> float:
    if unit not in units:
        raise ValueError(f"{name} must be one of {', '.join(units)}, not {unit!r}")
    return units[unit]


def _shortest(value: float) -> str:
    """Digits that give a single-precision number, or one scaled by a unit, back to the last bit."""
    return f"{value:.12g}"


def _rows(first: np.ndarray, values: np.ndarray, separator: str) -> str:
    return "".join(
        separator.join([str(start), *map(_shortest, row)]) + "\n"
        for start, row in zip(first.tolist(), values.tolist(), strict=True)
    )


def _fact(line: str) -> tuple[str, object]:
    """Name and value of a line above the table; what is not JSON is taken as text."""
    name, value = line.removeprefix("#").split(":", 1)
    try:
        return name.strip(), json.loads(value)
    except json.JSONDecodeError:
        return name.strip(), value.strip()


def _table(lines: list[str], separator: str, n_columns: int, path: str | Path) -> np.ndarray:
    """Numbers of a text table, shape (rows, columns), float64; empty fields are NaN."""
    rows = [line.split(separator) for line in lines if line.strip()]
    if not rows:
        raise ValueError(f"{path} holds no samples")
    for number, row in enumerate(rows, start=1):
        if len(row) != n_columns:
            raise ValueError(f"{path}: row {number} has {len(row)} fields where its header has {n_columns}")
    try:
        return np.array([[field.strip() or "nan" for field in row] for row in rows], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"{path} has a field that is no number: {error}") from error


def _rate_of(stamps: np.ndarray, path: str | Path, resolution: float) -> float:
    """Sample rate of regular time stamps in seconds, the roundest that their resolution allows."""
    if len(stamps) < 2 or not stamps[-1] > stamps[0]:
        raise ValueError(f"{path} does not say its rate, and its time stamps do not grow")
    n_steps, span = len(stamps) - 1, stamps[-1] - stamps[0]
    rate = n_steps / span
    grid = stamps[0] + np.arange(len(stamps)) / rate
    if np.abs(stamps - grid).max() * rate > REGULARITY:
        raise ValueError(f"{path} has irregular time stamps: resample it to a fixed rate first")
    rounder = (round(rate, digits) for digits in range(4))
    return float(next((r for r in rounder if r > 0 and abs(n_steps / r - span) <= 2 * resolution), rate))
