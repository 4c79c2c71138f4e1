# SPDX-License-Identifier: GPL-3.0-or-later
"""VIDIMU: daily activities seen by a webcam and worn by five orientation sensors.

Martinez-Zarzuela et al., Scientific Data 2023 (doi:10.1038/s41597-023-02554-9). What is known here of the
files was read in the dataset's public tools (twyncoder/vidimu-tools); nothing could be tried on the download
itself. The sensors' files hold orientations only: angular velocity follows from them, acceleration does not.
The poses' unit and upward axis are inferred. Video and sensors are off by up to half a second, which their
tools mend by comparing joint angles; windows are compared by their statistics here, so it is left.
"""

import csv
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.recording import ImuRecording
from w2w.core.keypoints.joint_sets import JOINT_SETS

BODY_34 = JOINT_SETS["body-34"]

IMU_RATE = 50.0
VIDEO_RATE = 30.0

ACTIVITIES = {
    f"A{number:02d}": name
    for number, name in enumerate(
        (
            "walk_forward", "walk_backward", "walk_along", "sit_to_stand", "move_right_arm",
            "move_left_arm", "drink_right_arm", "drink_left_arm", "assemble_both_arms",
            "throw_both_arms", "reachup_right_arm", "reachup_left_arm", "tear_both_arms",
        ),
        start=1,
    )
}  # fmt: skip

LAST_LOWER = 4
"""A01 to A04 were recorded with the sensors on the legs, the others with them on the arms."""


def _along(side: str, start: str, end: str, direction: tuple[float, float, float]) -> SensorSite:
    outward = direction[0] if side == "left" else -direction[0]
    return SensorSite(
        f"VIDIMU {side} {start} to {end}", None, (f"{side}_{start}",), (f"{side}_{end}",), 0.5,
        (outward, *direction[1:]),
    )  # fmt: skip


SITES: dict[str, str | SensorSite] = {
    "qsHIPS": "sacrum",
    "qsRUL": _along("right", "hip", "knee", (0.7, -0.7, 0)),
    "qsRLL": _along("right", "knee", "ankle", (0.7, -0.7, 0)),
    "qsLUL": _along("left", "hip", "knee", (0.7, -0.7, 0)),
    "qsLLL": _along("left", "knee", "ankle", (0.7, -0.7, 0)),
    "qsBACK": "upper spine",
    "qsRUA": _along("right", "shoulder", "elbow", (0, 0, 1)),
    "qsRLA": _along("right", "elbow", "wrist", (0, 0, 1)),
    "qsLUA": _along("left", "shoulder", "elbow", (0, 0, 1)),
    "qsLLA": _along("left", "elbow", "wrist", (0, 0, 1)),
}
"""Sensor -> where it sat: the middle of each segment, our reading of its name."""

LOWER, UPPER = tuple(SITES)[:5], tuple(SITES)[5:]

STEM = re.compile(r"S(\d\d)_(A\d\d)_T(\d\d)$")


class Trial(NamedTuple):
    """A trial with both."""

    recording: ImuRecording  # angular velocity at 50 Hz; the accelerations are 0, for there are none
    pose: np.ndarray
    """(F, 34, 3): joints of `BODY_34` at 30 Hz, in the file's unit and axes; NaN where there is none."""


def read_vidimu(folder: str | Path) -> tuple[Trial, ...]:
    """Read every trial that has both a ``.raw`` and a ``.csv`` file.

    `folder`: searched with all folders below it, such as ``VIDIMU/dataset/videoandimus``.
    Raises ValueError if there is none, or a file is damaged.
    """
    paths = sorted(path for path in Path(folder).rglob("*.raw") if STEM.match(path.stem))
    paths = [path for path in paths if path.with_suffix(".csv").is_file()]
    if not paths:
        raise ValueError(
            f"{folder} holds no trials S40_A01_T01.raw with a .csv of that name next to it: give "
            "VIDIMU's folder dataset/videoandimus"
        )
    return tuple(read_trial(path) for path in paths)


def read_trial(path: str | Path) -> Trial:
    """Read one trial by its ``.raw`` file.

    Raises ValueError if its name or content is not VIDIMU's.
    """
    path = Path(path)
    match = STEM.match(path.stem)
    if not match or match[2] not in ACTIVITIES:
        raise ValueError(
            f"{path.name} is no trial of VIDIMU: its name is not S<subject>_A<01 to 13>_T<trial>"
        )
    subject, activity, _ = match.groups()
    wanted = LOWER if int(activity[1:]) <= LAST_LOWER else UPPER
    recording = _rates(path, wanted)
    labelled = ImuRecording(
        recording.acc, recording.gyr, IMU_RATE, wanted, ACTIVITIES[activity], f"S{subject}", path.stem
    )
    return Trial(labelled, read_pose(path.with_suffix(".csv")))


def read_pose(path: str | Path) -> np.ndarray:
    """Joints of a video pose file, shape (F, 34, 3).

    Raises ValueError if a joint's columns are missing or a row is damaged.
    """
    names, rows = _table(Path(path))
    columns = []
    for joint in BODY_34.joints:
        for axis in "xyz":
            if f"{joint}_{axis}" not in names:
                raise ValueError(f"{path} is no pose of VIDIMU: it lacks the column {joint}_{axis}")
            columns.append(names.index(f"{joint}_{axis}"))
    try:
        values = np.array([[float(row[c] or "nan") for c in columns] for row in rows])
    except (ValueError, IndexError) as error:
        raise ValueError(f"{path} has a damaged row: {error}") from error
    return values.reshape(len(rows), len(BODY_34.joints), 3)


def _rates(path: Path, wanted: tuple[str, ...]) -> ImuRecording:
    """Angular velocities from interleaved orientations; the first row of each sensor is the N-pose."""
    names, rows = _table(path)
    lower = [name.lower() for name in names]
    if not {"quat", "w", "x", "y", "z"} <= set(lower):
        raise ValueError(f"{path} is no recording of VIDIMU: it lacks the columns QUAT, w, x, y, z")
    sensor, *components = (lower.index(name) for name in ("quat", "w", "x", "y", "z"))
    try:
        found = {
            name: np.array(
                [[float(row[c]) for c in components] for row in rows if row[sensor].strip() == name]
            )
            for name in wanted
        }
    except (ValueError, IndexError) as error:
        raise ValueError(f"{path} has a damaged row: {error}") from error
    missing = [name for name, values in found.items() if len(values) < 5]
    if missing:
        raise ValueError(f"{path} lacks the sensors {', '.join(missing)}")
    length = min(len(values) for values in found.values()) - 1
    rates = []
    for name, values in found.items():
        lengths = np.linalg.norm(values, axis=1)
        if not (np.abs(lengths - 1) < 0.1).all():
            raise ValueError(f"{path}: the orientations of {name} are no unit quaternions")
        rates.append(angular_velocity(values[1 : length + 1], IMU_RATE))
    gyr = np.stack(rates, axis=1)
    return ImuRecording(np.zeros_like(gyr), gyr, IMU_RATE, wanted)


def angular_velocity(quaternions: np.ndarray, rate: float) -> np.ndarray:
    """Angular velocity in the sensor's frame by central differences, rad/s.

    `quaternions` (T, 4): w, x, y, z, sensor to world.
    `rate`: samples per second.
    Returns (T, 3).
    """
    turns = Rotation.from_quat(quaternions[:, [1, 2, 3, 0]])
    inner = (turns[:-2].inv() * turns[2:]).as_rotvec() * (rate / 2)
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _table(path: Path) -> tuple[list[str], list[list[str]]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path} cannot be read as a csv file: {error}") from error
    if len(rows) < 3:
        raise ValueError(f"{path} has no rows")
    return [name.strip() for name in rows[0]], rows[1:]
