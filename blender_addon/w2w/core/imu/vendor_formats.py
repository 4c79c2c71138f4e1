# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings as Xsens's MT Manager, x-io's x-IMU3 and OpenSim write and read them.

One sensor a file, except OpenSim's orientations. Numbers are written with enough digits that reading them
back gives the same single-precision values.
"""

from pathlib import Path

import numpy as np

from ..files import write_text
from .recording import ImuRecording
from .text_tables import ACC_UNITS, GYR_UNITS, rate_of_stamps, read_numbers, table_text, text_lines

XSENS_COLUMNS = ("PacketCounter", "SampleTimeFine", "Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z")
XSENS_QUATERNION = ("Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3")

XSENS_TICKS = 10_000
"""Ticks of SampleTimeFine in a second (Xsens MT0101P, timestamp output)."""

X_IO_HEADER = (
    "Timestamp (us),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),"
    "Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)"
)

X_IO_QUATERNIONS, X_IO_QUATERNION_HEADER = "Quaternion.csv", "Timestamp (us),W,X,Y,Z"


def write_xsens_txt(
    path: str | Path, recording: ImuRecording, sensor: int = 0, quaternions: np.ndarray | None = None
) -> None:
    """Write one sensor as MT Manager exports it: m/s2, rad/s, tab-separated under ``//`` lines.

    OpenSim expects the file to be called ``<trial prefix><sensor name>.txt``. Quaternions (T, 4), w, x, y, z,
    turn sensor to world; by default they are those of the recording, where it has them.
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
    write_text(path, "\n".join([*head, "\t".join(names)]) + "\n" + table_text(stamps, values, "\t"))


def read_xsens_txt(path: str | Path) -> ImuRecording:
    """Read one sensor from an MT Manager export, with its orientation where the file has quaternions.

    Raises ValueError if a column of the acceleration or rate of turn is missing, or no rate is given.
    """
    lines = text_lines(path)
    head = [line for line in lines if line.startswith("//")]
    rate = next((line.split(":", 1)[1] for line in head if "Update Rate" in line), None)
    if rate is None:
        raise ValueError(f"{path} is no MT Manager export: it has no line '// Update Rate:'")
    body = [line for line in lines[len(head) :] if line]
    names = body[0].split("\t") if body else []
    missing = [name for name in XSENS_COLUMNS[2:] if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    table = read_numbers(body[1:], "\t", len(names), path)
    has_quaternion = set(XSENS_QUATERNION) <= set(names)
    columns = XSENS_COLUMNS[2:] + XSENS_QUATERNION * has_quaternion
    values = table[:, None, [names.index(name) for name in columns]]
    return ImuRecording(
        acc=values[..., :3],
        gyr=values[..., 3:6],
        rate=float(rate.strip().removesuffix("Hz")),
        orientation=values[..., 6:] if has_quaternion else None,
    )


def write_x_io(folder: str | Path, recording: ImuRecording, sensor: int = 0) -> None:
    """Write one sensor as x-io's x-IMU3 logs it: ``Inertial.csv`` in a folder, g, deg/s and microseconds.

    The folder is made if needed. ``Quaternion.csv`` lies beside it where the orientation is recorded.
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
    write_text(Path(folder) / "Inertial.csv", X_IO_HEADER + "\n" + table_text(stamps, values, ","))
    if recording.orientation is not None:
        quaternions = table_text(stamps, recording.orientation[:, sensor].astype(np.float64), ",")
        write_text(Path(folder) / X_IO_QUATERNIONS, f"{X_IO_QUATERNION_HEADER}\n{quaternions}")


def read_x_io(folder: str | Path) -> ImuRecording:
    """Read one sensor from the folder of an x-IMU3.

    Raises ValueError if there is no ``Inertial.csv`` with x-io's header, or its time stamps are not regular.
    """
    path = Path(folder) / "Inertial.csv"
    if not path.is_file():
        raise ValueError(f"{folder} is no x-IMU3 log: it has no Inertial.csv")
    lines = text_lines(path)
    if not lines or lines[0].strip() != X_IO_HEADER:
        raise ValueError(f"{path} does not start with x-io's header, {X_IO_HEADER}")
    table = read_numbers(lines[1:], ",", 7, path)
    orientation, turned = None, Path(folder) / X_IO_QUATERNIONS
    if turned.is_file():
        quaternions = read_numbers(text_lines(turned)[1:], ",", 5, turned)
        if np.array_equal(quaternions[:, 0], table[:, 0]):
            orientation = quaternions[:, None, 1:]
    return ImuRecording(
        acc=table[:, None, 4:] * ACC_UNITS["g"],
        gyr=table[:, None, 1:4] * GYR_UNITS["deg/s"],
        rate=rate_of_stamps(table[:, 0] / 1e6, path, 1e-6),
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
