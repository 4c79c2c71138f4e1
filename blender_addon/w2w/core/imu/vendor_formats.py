# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings as Xsens's MT Manager, x-io's x-IMU3 and OpenSim write and read them.

One sensor a file, except OpenSim's orientations. Numbers are written with enough digits that reading them
back gives the same single-precision values.
"""

from pathlib import Path

import numpy as np

from ..files import write_text
from . import text_tables
from .recording import ImuRecording

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
    text_tables.write_table(path, head, names, stamps, values, "\t")


def read_xsens_txt(path: str | Path) -> ImuRecording:
    """Read one sensor from an MT Manager export, with its orientation if the file has quaternions.

    Raises ValueError if a column of the acceleration or rate of turn is missing, or no rate is given.
    """
    lines = text_tables.text_lines(path)
    head = [line for line in lines if line.startswith("//")]
    rate = next((line.split(":", 1)[1] for line in head if "Update Rate" in line), None)
    if rate is None:
        raise ValueError(f"{path} is no MT Manager export: it has no line '// Update Rate:'")
    body = [line for line in lines[len(head) :] if line]
    columns = text_tables.read_table(body, "\t", XSENS_COLUMNS[2:], path)
    has_quaternion = set(XSENS_QUATERNION) <= set(columns)
    return ImuRecording(
        acc=text_tables.one_sensor(columns, XSENS_COLUMNS[2:5]),
        gyr=text_tables.one_sensor(columns, XSENS_COLUMNS[5:]),
        rate=float(rate.strip().removesuffix("Hz")),
        orientation=text_tables.one_sensor(columns, XSENS_QUATERNION) if has_quaternion else None,
    )


def write_x_io(folder: str | Path, recording: ImuRecording, sensor: int = 0) -> None:
    """Write one sensor as x-io's x-IMU3 logs it: ``Inertial.csv`` in a folder, g, deg/s and microseconds.

    The folder is made if needed. ``Quaternion.csv`` lies next to it if the orientation is recorded.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    gyr = recording.gyr[:, sensor].astype(np.float64) / text_tables.GYR_UNITS["deg/s"]
    acc = recording.acc[:, sensor].astype(np.float64) / text_tables.ACC_UNITS["g"]
    values = np.concatenate([gyr, acc], axis=1)
    stamps = np.rint(recording.time * 1e6).astype(np.int64)
    text_tables.write_table(Path(folder) / "Inertial.csv", [], X_IO_COLUMNS, stamps, values, ",")
    if recording.orientation is not None:
        quaternions = recording.orientation[:, sensor].astype(np.float64)
        text_tables.write_table(Path(folder) / "Quaternion.csv", [], X_IO_TURNS, stamps, quaternions, ",")


def read_x_io(folder: str | Path) -> ImuRecording:
    """Read one sensor from the folder of an x-IMU3.

    Raises ValueError if there is no ``Inertial.csv`` with x-io's header, or its time stamps are not regular.
    """
    path = Path(folder) / "Inertial.csv"
    if not path.is_file():
        raise ValueError(f"{folder} is no x-IMU3 log: it has no Inertial.csv")
    lines = text_tables.text_lines(path)
    header = ",".join(X_IO_COLUMNS)
    if lines[0].strip() != header:
        raise ValueError(f"{path} does not start with x-io's header, {header}")
    columns = text_tables.read_table(lines, ",", X_IO_COLUMNS, path)
    stamps, orientation, turned = columns["Timestamp (us)"], None, Path(folder) / "Quaternion.csv"
    if turned.is_file():
        turns = text_tables.read_table(text_tables.text_lines(turned), ",", X_IO_TURNS, turned)
        if np.array_equal(turns["Timestamp (us)"], stamps):
            orientation = text_tables.one_sensor(turns, X_IO_TURNS[1:])
    return ImuRecording(
        acc=text_tables.one_sensor(columns, X_IO_COLUMNS[4:]) * text_tables.ACC_UNITS["g"],
        gyr=text_tables.one_sensor(columns, X_IO_COLUMNS[1:4]) * text_tables.GYR_UNITS["deg/s"],
        rate=text_tables.rate_of_stamps(stamps / 1e6, path, 1e-6),
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
