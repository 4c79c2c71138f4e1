# SPDX-License-Identifier: GPL-3.0-or-later
"""Text tables of recordings as Xsens's MT Manager, x-io's x-IMU3 and OpenSim write and read them.

One sensor a file, except OpenSim's orientations. Numbers are written with enough digits that reading them
back gives the same single-precision values.
"""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..files import write_text
from ..wording import restated
from .recording import ImuRecording

ACC_UNITS = {"m/s2": 1.0, "g": 9.80665}
"""Units of specific force, in m/s2."""

GYR_UNITS = {"rad/s": 1.0, "deg/s": np.pi / 180}
"""Units of angular velocity, in rad/s."""

REGULARITY = 0.1
"""Largest deviation of a time stamp from a regular grid, in sample intervals."""


def text_lines(path: str | Path) -> list[str]:
    """Lines of a UTF-8 text, ended by line feeds alone: labels may hold other separators."""
    return Path(path).read_text(encoding="utf-8-sig").rstrip("\n").split("\n")


def unit_factor(units: dict[str, float], unit: str, name: str) -> float:
    if unit not in units:
        raise ValueError(f"{name} must be one of {', '.join(units)}, not {unit!r}")
    return units[unit]


def write_table(
    path: str | Path, head: list[str], names: Iterable[str], starts: Iterable, values: np.ndarray, mark: str
) -> None:
    """Write rows of what each starts with and its values, by enough digits to give single precision back.

    Lines of the head and the columns' names stand above them; `mark` separates fields.
    """
    rows = (
        mark.join([str(start), *(f"{value:.12g}" for value in row)])
        for start, row in zip(starts, values.tolist(), strict=True)
    )
    write_text(path, "\n".join([*head, mark.join(names), *rows]) + "\n")


def parse_fact(line: str) -> tuple[str, object]:
    """Name and value of a line above the table; what is not JSON is taken as text."""
    name, value = line.removeprefix("#").split(":", 1)
    try:
        return name.strip(), json.loads(value)
    except (ValueError, RecursionError):
        return name.strip(), value.strip()


def read_table(lines: list[str], mark: str, needed: Iterable[str], path: str | Path) -> dict[str, np.ndarray]:
    """Columns of a text table, float64, by the names in its first line; empty fields are NaN.

    Raises ValueError if one that is needed is not there, or a row is not whole.
    """
    names = [name.strip() for name in lines[0].split(mark)] if lines else []
    missing = [name for name in needed if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    rows = [line.split(mark) for line in lines[1:] if line.strip()]
    if not rows:
        raise ValueError(f"{path} holds no samples")
    for number, row in enumerate(rows, start=1):
        if len(row) != len(names):
            raise ValueError(f"{path}: row {number} has {len(row)} fields where its header has {len(names)}")
    with restated(f"{path} has a field that is no number:", ValueError):
        table = np.array([[field.strip() or "nan" for field in row] for row in rows], dtype=np.float64)
    return {name: table[:, names.index(name)] for name in names}


def one_sensor(columns: dict[str, np.ndarray], names: Iterable[str]) -> np.ndarray:
    """Some of a table's columns as one sensor's readings, shape (T, 1, columns)."""
    return np.stack([columns[name] for name in names], axis=1)[:, None]


def rate_of_stamps(stamps: np.ndarray, path: str | Path, resolution: float) -> float:
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


XSENS_COLUMNS = ("PacketCounter", "SampleTimeFine", "Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z")
XSENS_QUATERNION = ("Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3")

XSENS_TICKS = 10_000
"""Ticks of SampleTimeFine in a second (Xsens MT0101P, timestamp output)."""

X_IO_COLUMNS = (
    "Timestamp (us)", "Gyroscope X (deg/s)", "Gyroscope Y (deg/s)", "Gyroscope Z (deg/s)",
    "Accelerometer X (g)", "Accelerometer Y (g)", "Accelerometer Z (g)",
)  # fmt: skip
X_IO_TURNS = ("Timestamp (us)", "W", "X", "Y", "Z")


def write_xsens_txt(
    path: str | Path, recording: ImuRecording, sensor: int = 0, quaternions: np.ndarray | None = None
) -> None:
    """Write one sensor as MT Manager exports it: m/s2, rad/s, tab-separated under ``//`` lines.

    OpenSim expects the file to be called ``<trial prefix><sensor name>.txt``. Quaternions (T, 4), w, x, y, z,
    turn sensor to world; by default they are those of the recording, if it has them.
    """
    names: tuple[str, ...] = XSENS_COLUMNS
    values = np.concatenate([recording.acc[:, sensor], recording.gyr[:, sensor]], axis=1)
    if quaternions is None and recording.orientation is not None:
        quaternions = recording.orientation[:, sensor]
    if quaternions is not None:
        names += XSENS_QUATERNION
        values = np.concatenate([values, quaternions], axis=1)
    head = [
        "// Start Time: Unknown",
        f"// Update Rate: {recording.rate!r}Hz",
        "// Filter Profile: none",
        "// Option Flags: none",
        "// Firmware Version: W2W",
    ]
    ticks = np.rint(recording.time * XSENS_TICKS).astype(np.int64)
    stamps = [f"{count}\t{tick}" for count, tick in enumerate(ticks)]
    write_table(path, head, names, stamps, values, "\t")


def read_xsens_txt(path: str | Path) -> ImuRecording:
    """Read one sensor from an MT Manager export, with its orientation if the file has quaternions.

    Raises ValueError if a column of the acceleration or rate of turn is missing, or no rate is given.
    """
    lines = text_lines(path)
    head = [line for line in lines if line.startswith("//")]
    rate = next((line.split(":", 1)[1] for line in head if "Update Rate" in line), None)
    if rate is None:
        raise ValueError(f"{path} is no MT Manager export: it has no line '// Update Rate:'")
    body = [line for line in lines[len(head) :] if line]
    columns = read_table(body, "\t", XSENS_COLUMNS[2:], path)
    has_quaternion = set(XSENS_QUATERNION) <= set(columns)
    return ImuRecording(
        acc=one_sensor(columns, XSENS_COLUMNS[2:5]),
        gyr=one_sensor(columns, XSENS_COLUMNS[5:]),
        rate=float(rate.strip().removesuffix("Hz")),
        orientation=one_sensor(columns, XSENS_QUATERNION) if has_quaternion else None,
    )


def write_x_io(folder: str | Path, recording: ImuRecording, sensor: int = 0) -> None:
    """Write one sensor as x-io's x-IMU3 logs it: ``Inertial.csv`` in a folder, g, deg/s and microseconds.

    The folder is made if needed. ``Quaternion.csv`` lies next to it if the orientation is recorded.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    gyr = recording.gyr[:, sensor].astype(np.float64) / GYR_UNITS["deg/s"]
    acc = recording.acc[:, sensor].astype(np.float64) / ACC_UNITS["g"]
    values = np.concatenate([gyr, acc], axis=1)
    stamps = np.rint(recording.time * 1e6).astype(np.int64)
    write_table(Path(folder) / "Inertial.csv", [], X_IO_COLUMNS, stamps, values, ",")
    if recording.orientation is not None:
        quaternions = recording.orientation[:, sensor].astype(np.float64)
        write_table(Path(folder) / "Quaternion.csv", [], X_IO_TURNS, stamps, quaternions, ",")


def read_x_io(folder: str | Path) -> ImuRecording:
    """Read one sensor from the folder of an x-IMU3.

    Raises ValueError if there is no ``Inertial.csv`` with x-io's header, or its time stamps are not regular.
    """
    path = Path(folder) / "Inertial.csv"
    if not path.is_file():
        raise ValueError(f"{folder} is no x-IMU3 log: it has no Inertial.csv")
    lines = text_lines(path)
    header = ",".join(X_IO_COLUMNS)
    if lines[0].strip() != header:
        raise ValueError(f"{path} does not start with x-io's header, {header}")
    columns = read_table(lines, ",", X_IO_COLUMNS, path)
    stamps, orientation, turned = columns["Timestamp (us)"], None, Path(folder) / "Quaternion.csv"
    if turned.is_file():
        turns = read_table(text_lines(turned), ",", X_IO_TURNS, turned)
        if np.array_equal(turns["Timestamp (us)"], stamps):
            orientation = one_sensor(turns, X_IO_TURNS[1:])
    return ImuRecording(
        acc=one_sensor(columns, X_IO_COLUMNS[4:]) * ACC_UNITS["g"],
        gyr=one_sensor(columns, X_IO_COLUMNS[1:4]) * GYR_UNITS["deg/s"],
        rate=rate_of_stamps(stamps / 1e6, path, 1e-6),
        orientation=orientation,
    )


def write_orientation_sto(
    path: str | Path, quaternions: np.ndarray, rate: float, sites: tuple[str, ...]
) -> None:
    """Write orientations as OpenSense reads them: quaternions (T, N, 4), w, x, y, z, sensor to world.

    `sites` names the N sensors, without tabs; OpenSense looks for ``<body>_imu``. The world keeps its z axis
    up: give OpenSense ``sensor_to_opensim_rotations`` of (-pi/2, 0, 0), as for Xsens, to turn it to OpenSim's
    y axis.
    """
    head = [f"DataRate={rate!r}", "DataType=Quaternion", "version=3", "OpenSimVersion=4.5", "endheader"]
    head.append("\t".join(("time", *sites)))
    rows = (
        "\t".join([repr(k / rate), *(",".join(map(repr, q)) for q in row)])
        for k, row in enumerate(quaternions.tolist())
    )
    write_text(path, "\n".join([*head, *rows]) + "\n")
