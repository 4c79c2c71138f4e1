# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that hold joint positions, told from others by their first bytes or the names of their arrays."""

import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ..files import array_names
from ..motion.smpl_layouts import is_motion_x

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
