# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of joint positions: how they are told, and what they may lack (rate, unit, joint set, what is up)."""

import json
import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from math import isfinite
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Self

from ..files import array_names
from ..motion.sight import UPS, Up
from ..motion.smpl_layouts import is_motion_x
from ..motion.source import UnusableMotion
from ..wording import clean, restated
from .joint_sets import JOINT_SETS

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Metres in a unit of length."""

SPELLINGS = {
    "fps": "rate", "framerate": "rate", "frame_rate": "rate", "mocap_framerate": "rate", "rate_hz": "rate",
    "units": "unit", "up_axis": "up", "joints_are": "joint_set", "skeleton": "joint_set",
}  # fmt: skip
"""Other names of the facts, as people's files have them."""

UNIT_SPELLINGS = {
    "metre": "m", "meter": "m", "metres": "m", "meters": "m", "millimetres": "mm", "millimeters": "mm",
    "centimetres": "cm", "centimeters": "cm", "inches": "in", "feet": "ft",
}  # fmt: skip

MAX_BYTES = 1 << 20


@dataclass(frozen=True)
class PoseFacts:
    """Facts about joint positions, and the axis that is up in any motion file; None if unknown.

    Parameters
    ----------
    rate : float or None
        Frames per second.
    unit : str or None
        One of `UNITS`. The body is scaled by its limbs, so the unit only shows where a file is wrong.
    up : str or None
        The file's own axis that points up: one of `UPS`.
    joint_set : str or None
        One of `JOINT_SETS`.
    person : int or None
        Which of several people in a file, 1 being the one seen longest, which is the default.

    Raises
    ------
    ValueError
        If a fact is out of its range; the message names it.

    Examples
    --------
    >>> w2w.load("MY_CLIPS", pose=w2w.PoseFacts(rate=30.0, up="y"))  # where files do not say it
    <Motions: 12 of 3 activities, 0 files skipped>
    """

    rate: float | None = None
    unit: str | None = None
    up: Up | None = None
    joint_set: str | None = None
    person: int | None = None

    def __post_init__(self) -> None:
        is_rate = isinstance(self.rate, Real) and isfinite(self.rate) and self.rate > 0
        if self.rate is not None and not is_rate:
            raise ValueError(f"the pose's rate must be frames a second, above 0, not {self.rate!r}")
        if self.person is not None and not (isinstance(self.person, Integral) and self.person >= 1):
            raise ValueError(f"people are counted from 1 on: there is no person {self.person!r}")
        for name, known in (("unit", UNITS), ("up", UPS), ("joint_set", JOINT_SETS)):
            value = getattr(self, name)
            if value is not None and not (isinstance(value, str) and value in known):
                raise ValueError(f"the pose's {name} must be one of {', '.join(known)}, not {value!r}")

    def completed(self, other: Self) -> Self:
        """These facts, with the missing ones from the other."""
        missing = {item.name for item in fields(self) if getattr(self, item.name) is None}
        return replace(self, **{name: getattr(other, name) for name in missing})

    def at(self, rate: float) -> Self:
        """These facts with a file's own rate, which goes before that of all files; 0 changes nothing."""
        return replace(self, rate=rate) if rate else self


IN_FILES = {item.name for item in fields(PoseFacts)} - {"person"}
"""Facts that files may state."""


def facts_of(content: Mapping[str, Any]) -> PoseFacts:
    """The facts in a file's content, under their usual names.

    Raises ValueError if one is out of its range.
    """
    given: dict[str, Any] = {}
    for key, value in content.items():
        name = named(key)
        if name in IN_FILES and value not in (None, ""):
            given[name] = value
    return PoseFacts(**{name: _fact(name, value) for name, value in given.items()})


def named(key: object) -> str:
    """The usual name of a fact that a file calls `key`."""
    return SPELLINGS.get(str(key).lower(), str(key).lower())


def _fact(name: str, value: Any) -> Any:
    if name == "rate":
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"the pose's rate must be a number of frames a second, not {value!r}")
        return float(min(value, 1e300))
    if not isinstance(value, str):
        raise ValueError(f"the pose's {name} must be text, not {value!r}")
    plain = value.strip().lower()
    return UNIT_SPELLINGS.get(plain, plain) if name == "unit" else plain


def side_car(path: Path) -> Path | None:
    """The file NAME.json with the facts of NAME.csv, NAME.npy or NAME.npz, if there is one."""
    facts = path.with_suffix(".json")
    # a path's own call costs more
    return facts if path.suffix.lower() != ".json" and os.path.isfile(facts) else None  # noqa: PTH113


def up_beside(path: Path) -> Up | None:
    """The axis that NAME.json next to a file of poses says is up; None if nothing says it."""
    said: list[Any] = []
    with suppress(UnusableMotion):  # another program's
        said = [value for key, value in _beside(path).items() if named(key) == "up"]
    return _facts_beside(path, {"up": said[0]} if said else {}).up


def side_car_facts(path: Path) -> PoseFacts:
    """The facts in a side-car; UnusableMotion if there is one that cannot be understood."""
    return _facts_beside(path, _beside(path))


def _facts_beside(path: Path, content: Mapping[str, Any]) -> PoseFacts:
    with restated(f"{clean(path.with_suffix('.json').name)} next to it:", ValueError, UnusableMotion):
        return facts_of(content)


def _beside(path: Path) -> dict[str, Any]:
    """The content of a side-car, {} without one; UnusableMotion if it cannot be understood."""
    if (file := side_car(path)) is None:
        return {}
    wrong = f"{clean(file.name)} next to it"
    with restated(f"{wrong} cannot be read as JSON:", (OSError, ValueError, RecursionError), UnusableMotion):
        if file.stat().st_size > MAX_BYTES:
            raise UnusableMotion(f"{wrong} is too large to say its rate and unit")
        content = json.loads(file.read_text(encoding="utf-8-sig"))
    if not isinstance(content, dict):
        raise UnusableMotion(f"{wrong} must be a JSON object with 'rate', 'unit', 'up', 'joint_set'")
    return content


POSITION_KEYS = (
    "positions", "keypoints", "joints", "joints3d", "joints_3d", "keypoints3d", "keypoints_3d",
    "positions_3d", "poses3d", "poses_3d", "kp3d", "xyz", "posed_joints", "pred_joint_coords",
    "pred_keypoints_3d",
)  # fmt: skip
"""Names of the array of positions in npz and json files."""

WORLD_KEYS = ("pose_world_landmarks", "poseWorldLandmarks", "world_landmarks", "worldLandmarks")
"""Names of MediaPipe's landmarks in metres."""

JSON_KEYS = ("positions", "keypoints", "keypoints_3d", "instance_info", "segment_lengths", *WORLD_KEYS)
"""The keys by which a JSON file is recognised as joint positions, those of estimators last."""

SMPL_KEYS = ("transl", "global_orient", "body_pose", "betas")
"""The keys by which one is recognised as parameters of SMPL-X (Fit3D), whichever comes first."""

MOTIVE = "Format Version,"
"""The beginning of a table that OptiTrack's Motive exported."""

HEAD_BYTES = 16384
FEWEST_JOINTS = 8

COLUMN = re.compile(r"(?P<joint>.*\S)\s*[\s_.:\-](?P<axis>[xyz])", re.IGNORECASE | re.DOTALL)
"""A column of a joint's coordinate: ``left_hip_x``, ``LeftHip.X``."""

NUMBERED = re.compile(r"(?P<axis>[xyz])_?(?P<joint>\d{1,3})", re.IGNORECASE)
"""The same by the joint's number: ``x0``, as people save MediaPipe's landmarks."""

PLACED = re.compile(
    r"(?P<joint>.*\S)[\s_.:\-]+(?:position|pos|location|loc|translation)", re.IGNORECASE | re.DOTALL
)
"""A joint's name in a table that holds its turns, too: ``Hips_position``."""


def joint_columns(names: Iterable[str]) -> dict[str, tuple[int, ...]]:
    """Joint -> places of its x, y and z among a table's columns, for joints that have all three."""
    columns: dict[str, dict[str, int]] = {}
    for place, name in enumerate(names):
        plain = name.strip().strip('"')
        if column := COLUMN.fullmatch(plain) or NUMBERED.fullmatch(plain):
            columns.setdefault(column["joint"], {})[column["axis"].lower()] = place
    whole = {joint: tuple(axes[axis] for axis in "xyz") for joint, axes in columns.items() if len(axes) == 3}
    placed = {found["joint"]: places for name, places in whole.items() if (found := PLACED.fullmatch(name))}
    return placed or whole


def may_hold_joints(path: Path) -> bool:
    """Whether a csv or json file, by its first bytes, holds joint positions; never waits for a pipe."""
    text = _head(path)
    if path.suffix.lower() == ".json":
        return any(f'"{key}"' in text for key in (*JSON_KEYS, *SMPL_KEYS))
    header = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    is_motive = header.startswith(MOTIVE) and ",Bone," in text
    return is_motive or len(joint_columns(re.split(r"[,;\t]", header))) >= FEWEST_JOINTS


def _head(path: Path) -> str:
    """The first characters of a text file, "" if there is no such file."""
    with suppress(OSError):
        if path.is_file():
            with path.open("rb") as stream:
                return stream.read(HEAD_BYTES).decode("utf-8", "replace").lstrip("\ufeff")
    return ""


def is_joint_file(path: Path) -> bool:
    """Whether a file is to be read as joint positions rather than as another kind of motion."""
    suffix = path.suffix.lower()
    if suffix == ".json":
        text = _head(path)
        named = [any(f'"{key}"' in text for key in keys) for keys in (JSON_KEYS, SMPL_KEYS)]
        return named[0] or not named[1]
    if suffix != ".npz":
        return not is_motion_x(path)
    try:
        names = set(array_names(path)) if path.is_file() else set()
    except (OSError, ValueError):
        return False
    rotations = {"poses", "bodyPose", "pose_body", "body_pose", "smpl_poses", "pose_world", "pred_rotmat"}
    return not rotations & names and bool(set(POSITION_KEYS) & names)
