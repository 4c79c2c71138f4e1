# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint positions as text: csv by named columns, trc, json of W2W's own layout or of estimators."""

import csv
import re
from collections.abc import Iterable
from contextlib import suppress
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from ..csv_tables import SEPARATORS, decoded
from ..motion.source import UnusableMotion, read_json
from ..wording import restated
from .facts import MOTIVE, WORLD_KEYS, PoseFacts, facts_of, joint_columns
from .naming import RawPose

TIME_COLUMNS = {
    "time": (1.0,), "time_s": (1.0,), "seconds": (1.0,), "time (seconds)": (1.0,), "time_ms": (1e-3,),
    "timestamp_ms": (1e-3,), "timestamp": (1.0, 1e-3, 1e-6, 1e-9),
}  # fmt: skip
"""Columns with a frame's time, and its unit in seconds; of several the one that makes a `USUAL_STEP`."""

USUAL_STEP = (1e-3, 0.2)
"""Seconds from frame to frame."""

UNEVEN = 0.25
"""Frames whose steps in time stray further from the median, as part of it, are no regular clip."""

MODEL = "body_"
"""FreeMoCap's name of the model that a body's point is from, before the point's."""

MOTIVE_LINES = 12
"""Lines in which Motive's header ends."""

NUMBER = r"(?:landmark|joint|point|keypoint|kp)?[ _]?(\d{1,3})"
"""A joint's number instead of a name."""

NOT_SO = (KeyError, TypeError, AttributeError, IndexError)
"""Errors of content that is laid out otherwise."""

JSON_ARRAYS = ("positions", "keypoints", "keypoints_3d", "joints")


def read_csv_pose(path: Path) -> RawPose:
    """Positions of a csv: columns ``left_hip_x``, ``left_hip_y``, ... in any order, a frame a row.

    Raises UnusableMotion if the columns are no joints' or a row is damaged.
    """
    text, _ = decoded(path)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    with restated("it cannot be read as csv:", csv.Error, UnusableMotion):
        return _motive(lines) if text.startswith(MOTIVE) else _table(lines)


def _table(lines: list[str]) -> RawPose:
    """Positions of a table whose first line names its columns."""
    header = lines[0] if lines else ""
    separator = max(SEPARATORS, key=header.count)
    columns = next(csv.reader([header], delimiter=separator), [])
    places = joint_columns(columns)
    if not places:
        raise UnusableMotion(
            "its first line names no joints; the columns must be left_hip_x, left_hip_y, left_hip_z and so on"
        )
    table = _numbers(lines[1:], separator, len(columns), decimal_comma=separator == ";")
    wanted = [place for axes in places.values() for place in axes]
    positions = table[:, wanted].reshape(len(table), -1, 3)
    numbers = [re.fullmatch(NUMBER, name) for name in places]
    names = () if all(numbers) else tuple(name.removeprefix(MODEL) for name in places)
    if not names:  # joints have numbers, or the same name with a number
        order = np.argsort([int(number[1]) for number in numbers if number], kind="stable")
        positions = positions[:, order]
    return RawPose(positions, names, PoseFacts(rate=_rate(columns, table)))


def _motive(lines: list[str]) -> RawPose:
    """Positions of the first person's bones in Motive's table: kinds and names stand above the axes."""
    rows = list(csv.reader(lines[:MOTIVE_LINES]))
    top = next((number for number, row in enumerate(rows) if row[:1] == ["Frame"]), 0)
    about = dict(zip(rows[0][::2], rows[0][1::2], strict=False))
    named = {row[1]: row for row in rows[1:top] if row[1:]}
    if not named.keys() >= {"Type", "Name"} or about.get("Coordinate Space", "Global") != "Global":
        raise UnusableMotion(
            "it holds no bones in global coordinates: export those from Motive, or BVH or FBX"
        )
    columns = list(zip_longest(named["Type"], named["Name"], rows[top - 1], rows[top], fillvalue=""))
    whose = next((name.rpartition(":")[0] for kind, name, *_ in columns if kind == "Bone"), "")
    header = [
        f"{name} {axis}" if (kind, name.rpartition(":")[0], what) == ("Bone", whose, "Position") else axis
        for kind, name, what, axis in columns
    ]
    raw = _table([",".join(header), *lines[top + 1 :]])
    return raw._replace(facts=facts_of({"unit": about.get("Length Units")}).completed(raw.facts))


def read_trc_pose(path: Path) -> RawPose:
    """Positions, rate and unit of a trc file (track row column), as motion analysis and OpenSim write it.

    Raises UnusableMotion if it is damaged.
    """
    lines = decoded(path)[0].splitlines()
    if len(lines) < 6 or not lines[0].startswith("PathFileType"):
        raise UnusableMotion(
            "it is damaged or no trc file: it does not begin with PathFileType and its header"
        )
    head = dict(zip(lines[1].split(), lines[2].split(), strict=False))
    names = [name.strip() for name in lines[3].split("\t")[2:] if name.strip()]
    rows = [line.split("\t")[2 : 2 + 3 * len(names)] for line in lines[5:] if line.strip()]
    short = next((number for number, row in enumerate(rows, 1) if len(row) < 3 * len(names) - 3), None)
    if not names or short:
        raise UnusableMotion(f"its row {short} is cut short" if short else "it names no markers")
    table = _floats(rows, (len(rows), 3 * len(names)))
    rate = float(head.get("DataRate", 0))
    facts = facts_of({"rate": rate if rate > 0 else None, "unit": head.get("Units")})
    return RawPose(table.reshape(len(rows), -1, 3), tuple(names), facts, firm=True)


def _numbers(lines: list[str], separator: str, width: int, decimal_comma: bool) -> np.ndarray:
    """Rows of numbers; empty cells and words such as ``nan`` are NaN."""
    rows = list(csv.reader(lines, delimiter=separator))
    for number, cells in enumerate(rows, start=1):
        if len(cells) != width:
            raise UnusableMotion(f"its row {number} has {len(cells)} cells; the header has {width}")
    if decimal_comma:
        rows = [[cell.replace(",", ".") for cell in cells] for cells in rows]
    return _floats(rows, (len(lines), width))


def _floats(rows: Iterable[Iterable[str]], shape: tuple[int, int]) -> np.ndarray:
    """A table of the cells' numbers; NaN in cells without one and where there is no cell."""
    table = np.full(shape, np.nan)
    for number, cells in enumerate(rows):
        for place, cell in enumerate(cells):
            with suppress(ValueError):
                table[number, place] = float(cell)
    return table


def _rate(columns: list[str], table: np.ndarray) -> float | None:
    """Frames per second, from a column with the time; None without one."""
    plain = [name.strip().lower() for name in columns]
    column = next((name for name in TIME_COLUMNS if name in plain), None)
    if column is None or len(table) < 2:
        return None
    steps, units = np.diff(table[:, plain.index(column)]), TIME_COLUMNS[column]
    fitting = [unit for unit in units if USUAL_STEP[0] < unit * np.median(steps) <= USUAL_STEP[1]]
    if len(units) > 1 and not fitting:  # text, or frames in any unit
        return None
    steps = steps * [*fitting, *units][0]
    step = float(np.median(steps))
    if not step > 0:
        raise UnusableMotion(f"its column {column} does not rise from row to row")
    if not (np.abs(steps - step) <= UNEVEN * step).all():
        raise UnusableMotion(
            f"its frames are not regular: the steps of its column {column} reach from {steps.min():.4g} to "
            f"{steps.max():.4g} s; resample it to one rate"
        )
    return float(1 / steps.mean())


def read_json_pose(path: Path) -> RawPose:
    """Positions of a json file: ``{"rate": 30, "positions": [frames][joints][x, y, z], ...}``, or MMPose's.

    Raises UnusableMotion if it is neither.
    """
    content = read_json(path)
    if (seen := _mediapipe(content)) is not None:
        return seen
    if not isinstance(content, dict):
        raise UnusableMotion(_WRONG_JSON)
    if "data_by_frame" in content:
        return _freemocap(content["data_by_frame"])
    if "people" in content:
        raise UnusableMotion(
            "it is one frame of OpenPose's output: join the frames of a clip, lifted to 3D, in one file"
        )
    names = content.get("joint_names", content.get("names", ()))
    if not (isinstance(names, list | tuple) and all(isinstance(name, str) for name in names)):
        raise UnusableMotion("its 'joint_names' must be a list of names")
    if "instance_info" in content:
        return RawPose(_array(_mmpose_frames(content["instance_info"])), tuple(names), facts_of(content))
    key = next((key for key in JSON_ARRAYS if isinstance(content.get(key), list)), None)
    if key is None:
        raise UnusableMotion(_WRONG_JSON)
    array = _array(content[key])
    if names and (array.ndim != 3 or array.shape[1] != len(names) or array.shape[2] < 3):
        raise UnusableMotion(
            f"its '{key}' have shape {array.shape}, and there are {len(names)} 'joint_names'"
        )
    return RawPose(array, tuple(names), facts_of(content))


_WRONG_JSON = (
    'it is no JSON object with "positions": a list of frames, each a list of joints, each [x, y, z]; with '
    '"rate", "unit", "up" and "joint_set" next to it'
)


def _mediapipe(content: Any) -> RawPose | None:
    """MediaPipe's landmarks in metres, of a list of its results, a frame each; None if there are none."""
    if isinstance(content, dict):
        content = next((item for item in content.values() if isinstance(item, list)), [])
    frames = [frame.get("pose", frame) if isinstance(frame, dict) else {} for frame in content]
    if not any(isinstance(frame, dict) and frame.keys() & set(WORLD_KEYS) for frame in frames):
        return None
    with restated("its landmarks are not as MediaPipe writes them", NOT_SO, UnusableMotion):
        found: list[Any] = [
            next((frame[key] for key in WORLD_KEYS if frame.get(key)), []) for frame in frames
        ]
        people = [each if not each or _is_person(each[0]) else [each] for each in found]
        points = [[[_place(point) for point in person] for person in frame] for frame in people]
    return RawPose(_array(_filled(points)), (), PoseFacts(unit="m", joint_set="blazepose-33"), "-y")


def _is_person(value: Any) -> bool:
    """Whether it is a list of points, not a point."""
    return isinstance(value, list) and not isinstance(value[0], int | float)


def _place(point: Any) -> list[float]:
    return [point[axis] for axis in "xyz"] if isinstance(point, dict) else point[:3]


def _freemocap(frames: Any) -> RawPose:
    """Positions of FreeMoCap's json by frame, in millimetres."""
    with restated("its 'data_by_frame' is not as FreeMoCap writes it", NOT_SO, UnusableMotion):
        points = [frame["tracked_points"] for frame in frames.values()]
        names = [name for name in points[0] if name.startswith(MODEL)]
        positions = _array([[_place(frame[name]) for name in names] for frame in points])
    return RawPose(positions, tuple(name.removeprefix(MODEL) for name in names), PoseFacts(unit="mm"))


def _mmpose_frames(info: Any) -> list[Any]:
    """The people of each frame of MMPose's ``instance_info``, as many in each."""
    wrong = "its 'instance_info' is not as MMPose writes it, or shows nobody"
    with restated(wrong, (KeyError, TypeError), UnusableMotion):
        return _filled([[person["keypoints"] for person in frame["instances"]] for frame in info])


def _filled(frames: list[list[Any]]) -> list[Any]:
    """Frames with as many people in each: whoever is missing is not seen."""
    n_joints = next((len(frame[0]) for frame in frames if frame), 0)
    if not n_joints:
        raise UnusableMotion("it shows nobody")
    nobody, most = [[float("nan")] * 3] * n_joints, max(map(len, frames))
    return [[*frame, *[nobody] * (most - len(frame))] for frame in frames]


def _array(values: list[Any]) -> np.ndarray:
    """Nested lists as an array; null is NaN."""
    wrong = "its positions are no regular list of frames, joints and numbers: give every frame all joints"
    with restated(wrong, (ValueError, TypeError, OverflowError, RecursionError), UnusableMotion):
        return np.array(_without_null(values), dtype=np.float64)


def _without_null(values: Any) -> Any:
    """Nested lists with a joint of nulls, NaN to NumPy, for a null joint: it was not seen."""
    lists = [value for value in values if isinstance(value, list)] if isinstance(values, list) else []
    if not lists:
        return values
    unseen = [None] * len(lists[0])
    return [_without_null(unseen if value is None else value) for value in values]
