# SPDX-License-Identifier: GPL-3.0-or-later
"""MM-Fit: workouts seen by a camera and worn by two watches, two phones and an earbud.

Stromback, Huang and Radu, IMWUT 2020 (doi:10.1145/3432701). What is known here of the files was read in the
dataset's public tools (KDMStromback/mm-fit); nothing could be tried on the download itself. Not stated there,
and so inferred from each file and reported: the units of acceleration and rate, which axis of the 3D poses
points up, and whether their left is the person's left.
"""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.files import read_npy
from w2w.core.filtering import butterworth
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.trajectory import runs
from w2w.core.imu.vendor_formats import ACC_UNITS, GYR_UNITS
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.wording import restated

MM_FIT_17 = JOINT_SETS["mm-fit-17"]

CAMERA_RATE = 30.0
"""Frames per second of the camera whose frame numbers are the clock of all streams."""

RATE_HZ = 50.0
"""What all devices are brought to, as in the authors' own training."""

BAND = 0.4
"""Low-pass before resampling, as a part of `RATE_HZ`."""

LONGEST_GAP_S = 0.1

DEVICES = {
    "sw_l": "left wrist", "sw_r": "right wrist",
    "sp_l": "left front pocket", "sp_r": "right front pocket", "eb_l": "left ear",
}  # fmt: skip
"""Prefix of each device's files -> where it was worn: watches, phones in the trouser pockets, an earbud."""

ACTIVITIES = (
    "squats", "lunges", "bicep_curls", "situps", "pushups", "tricep_extensions", "dumbbell_rows",
    "jumping_jacks", "dumbbell_shoulder_press", "lateral_shoulder_raises",
)  # fmt: skip

NON_ACTIVITY = "non_activity"
"""The authors' eleventh class: whatever is done outside the labelled sets."""

REST_S, SHORTEST_REST_S = 30.0, 5.0
"""Rests are cut into pieces of the one length, and shorter ones than the other left out, seconds."""

UNSEEN_FRAMES = 15
"""Frames in a row without a pose at which a rest is cut."""

PARTICIPANTS = dict(enumerate((2, 0, 1, 0, 1, 2, 0, 1, 0, 1, 0, 1, 3, 4, 0, 1, 5, 6, 7, 8, 9)))
"""Who did each workout w00 to w20."""

LARGEST_RATE = 35.0
"""rad/s, 2000 degrees a second: no gyroscope of these devices reads more, nor does a person turn faster."""


class Exercise(NamedTuple):
    """A set of repetitions."""

    recording: ImuRecording  # the devices that ran, at `RATE_HZ`; NaN where a stream has a gap
    pose: np.ndarray
    """(F, 17, 3): joints of `MM_FIT_17` at `CAMERA_RATE`, in the file's own unit and axes; NaN where there is
    none."""


class _Stream(NamedTuple):
    seconds: np.ndarray
    values: np.ndarray
    rate: float


def read_mmfit(folder: str | Path, rests: bool = False) -> tuple[Exercise, ...]:
    """Read every labelled exercise of every workout that has a 3D pose.

    `folder`: holds ``w00`` to ``w20``, or some of them; the folder ``mm-fit`` of the download.
    `rests`: also what is between the sets, as `NON_ACTIVITY`. The pieces of one rest are one clip.
    Gives only the devices that all exercises of the folder have in common, in the order of `DEVICES`.
    Raises ValueError if there is no workout, or a file is not what it should be.
    """
    workouts = sorted(path for path in Path(folder).glob("w[0-9][0-9]") if path.is_dir())
    workouts = [path for path in workouts if (path / f"{path.name}_labels.csv").is_file()]
    if not workouts:
        raise ValueError(
            f"{folder} holds no workouts w00, w01, ... with wNN_labels.csv: give MM-Fit's own folder"
        )
    posed = [path for path in workouts if (path / f"{path.name}_pose_3d.npy").is_file()]
    if not posed:
        raise ValueError(f"no workout in {folder} has its wNN_pose_3d.npy")
    common = [
        name
        for name in DEVICES
        if all((w / f"{w.name}_{name}_{kind}.npy").is_file() for w in posed for kind in ("acc", "gyr"))
    ]
    if not common:
        raise ValueError(f"no device's acc and gyr files are in all workouts of {folder}")
    found = tuple(exercise for workout in posed for exercise in _workout(workout, common, rests))
    if not found:
        raise ValueError(f"no wNN_labels.csv in {folder} has a row of an exercise")
    return found


def read_labels(path: str | Path) -> list[tuple[int, int, int, str]]:
    """Rows of ``wNN_labels.csv``: first frame, last frame, repetitions, activity.

    Raises ValueError if a row is not that.
    """
    rows = []
    unreadable = restated(f"{path} cannot be read as csv:", csv.Error)
    with unreadable, Path(path).open(newline="", encoding="utf-8-sig") as stream:
        for number, row in enumerate(csv.reader(stream), start=1):
            try:
                start, stop, repetitions, activity = (cell.strip() for cell in row)
                rows.append((int(start), int(stop), int(repetitions), activity))
            except ValueError as error:
                raise ValueError(
                    f"{path}, line {number}: it must be first frame, last frame, repetitions, activity"
                ) from error
            if activity not in (*ACTIVITIES, NON_ACTIVITY):
                raise ValueError(f"{path}, line {number}: MM-Fit has no activity {activity!r}")
            if not 0 <= rows[-1][0] < rows[-1][1]:
                raise ValueError(f"{path}, line {number}: frames {start} to {stop} are no stretch of time")
    return rows


class _Stretch(NamedTuple):
    start: int
    stop: int
    activity: str
    clip: str


def _stretches(name: str, rows: list[tuple[int, int, int, str]], seen: np.ndarray | None) -> list[_Stretch]:
    """The sets of a workout and, where the frames with a pose are given, the rests between them."""
    found = [
        _Stretch(start, stop, activity, f"{name} set {number:02d}")
        for number, (start, stop, _, activity) in enumerate(rows)
        if activity != NON_ACTIVITY
    ]
    if seen is None:
        return found
    begins = np.array([stretch.start for stretch in found])
    in_set = [(seen >= stretch.start) & (seen < stretch.stop) for stretch in found]
    idle = seen[~np.any(in_set, axis=0)] if found else seen
    longest, shortest = round(REST_S * CAMERA_RATE), round(SHORTEST_REST_S * CAMERA_RATE)
    for run in np.split(idle, np.flatnonzero(np.diff(idle) > UNSEEN_FRAMES) + 1):
        if not len(run):
            continue
        first, last = int(run[0]), int(run[-1]) + 1
        clip = f"{name} rest {int((begins < first).sum()):02d}"
        for start in range(first, last, longest):
            stop = min(start + longest, last)
            if stop - start >= shortest:
                found.append(_Stretch(start, stop, NON_ACTIVITY, clip))
    return found


def _workout(folder: Path, devices: list[str], rests: bool) -> list[Exercise]:
    name = folder.name
    frames, joints = _pose(folder / f"{name}_pose_3d.npy")
    streams = {}
    for device in devices:
        for kind, units in (("acc", ACC_UNITS), ("gyr", GYR_UNITS)):
            path = folder / f"{name}_{device}_{kind}.npy"
            stream = _stream(path)
            unit = guessed_unit(stream.values, kind, path)
            streams[device, kind] = stream._replace(values=stream.values * units[unit])
    exercises = []
    rows = read_labels(folder / f"{name}_labels.csv")
    for start, stop, activity, clip in _stretches(name, rows, frames if rests else None):
        times = start / CAMERA_RATE + np.arange(round((stop - start) / CAMERA_RATE * RATE_HZ)) / RATE_HZ
        pose = np.full((stop - start, len(MM_FIT_17.joints), 3), np.nan)
        inside = (frames >= start) & (frames < stop)
        pose[frames[inside] - start] = joints[inside]
        acc, gyr = (
            np.stack([_resampled(streams[device, kind], times) for device in devices], axis=1)
            for kind in ("acc", "gyr")
        )
        recording = ImuRecording(
            acc, gyr, RATE_HZ, tuple(DEVICES[device] for device in devices), activity,
            f"person {PARTICIPANTS.get(int(name[1:]), name)}", clip,
        )  # fmt: skip
        exercises.append(Exercise(recording, pose))
    return exercises


def guessed_unit(values: np.ndarray, kind: str, path: str | Path = "") -> str:
    """The unit that makes a stream possible: acceleration rests near 1 g, rates stay below `LARGEST_RATE`.

    Raises ValueError if neither m/s2 nor g fits.
    """
    length = np.linalg.norm(values, axis=1)
    if kind == "gyr":
        return "rad/s" if np.percentile(length, 99.9) <= LARGEST_RATE else "deg/s"
    middle = float(np.median(length))
    for unit, factor in ACC_UNITS.items():
        if abs(middle * factor / 9.80665 - 1) < 0.3:
            return unit
    raise ValueError(f"{path}: acceleration of median length {middle:.3g} is neither m/s2 nor g")


def _array(path: Path) -> np.ndarray:
    values = read_npy(path)
    if values.dtype.kind not in "fiu":
        raise ValueError(f"{path} is no npy file of numbers")
    return values.astype(np.float64)


def _stream(path: Path) -> _Stream:
    """Samples on the camera's clock: its frame numbers are whole, the device's own milliseconds are finer."""
    table = _array(path)
    if table.ndim != 2 or table.shape[1] != 5 or len(table) < 10:
        raise ValueError(f"{path} must have rows of frame, timestamp, x, y, z, not the shape {table.shape}")
    table = table[np.isfinite(table).all(axis=1)]
    table = table[np.argsort(table[:, 1], kind="stable")]
    frame, milliseconds = table[:, 0], table[:, 1] - table[0, 1]
    if milliseconds[-1] <= 0:
        raise ValueError(f"{path}: its timestamps do not advance")
    slope, start = np.polyfit(milliseconds, frame / CAMERA_RATE, 1)
    if not 0.0005 < slope < 0.002:
        raise ValueError(f"{path}: its frames (30 a second) and timestamps (ms) do not run together")
    rate = 1 / (slope * float(np.median(np.diff(milliseconds)) or 1.0))
    return _Stream(start + slope * milliseconds, table[:, 2:], rate)


def _resampled(stream: _Stream, times: np.ndarray) -> np.ndarray:
    """Values (len(times), 3); NaN in gaps and outside the stream."""
    margin = 1.0
    near = (stream.seconds > times[0] - margin) & (stream.seconds < times[-1] + margin)
    seconds, values = stream.seconds[near], stream.values[near]
    if len(seconds) < 10:
        return np.full((len(times), 3), np.nan)
    if 0.45 * stream.rate > BAND * RATE_HZ:
        values = butterworth(values.T, stream.rate, BAND * RATE_HZ, zero_phase=True).T
    result = np.stack([np.interp(times, seconds, column) for column in values.T], axis=1)
    gaps = np.diff(seconds)
    for start, stop in runs(gaps > LONGEST_GAP_S):
        result[(times > seconds[start]) & (times < seconds[stop])] = np.nan
    result[(times < seconds[0]) | (times > seconds[-1])] = np.nan
    return result


def _pose(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Frame numbers (F,) and joints (F, 17, 3) of a (3, F, 1 + J) array; more joints are left out."""
    table = _array(path)
    n_joints = len(MM_FIT_17.joints)
    if table.ndim != 3 or table.shape[0] != 3 or table.shape[2] < 1 + n_joints:
        raise ValueError(
            f"{path} must have the shape (3, frames, 1 + {n_joints}), frame numbers first, not {table.shape}"
        )
    frames = table[0, :, 0].astype(np.int64)
    if (np.diff(frames) <= 0).any():
        raise ValueError(f"{path}: its frame numbers do not rise")
    return frames, table[:, :, 1 : 1 + n_joints].transpose(1, 2, 0)
