# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognise files of joint positions from video by their first bytes, before reading them whole."""

from __future__ import annotations

import re
import stat
from pathlib import Path

from ..files import array_names

POSITION_KEYS = (
    "positions", "keypoints", "joints", "joints3d", "joints_3d", "keypoints3d", "keypoints_3d",
    "positions_3d", "poses3d", "poses_3d", "kp3d", "xyz",
)  # fmt: skip
"""Names of the array of positions in npz and json files."""

JSON_KEYS = ("positions", "keypoints", "keypoints_3d", "instance_info")
"""Those of them by which a json file is known; the last is MMPose's."""

TEXT_SUFFIXES = (".csv", ".json")
"""Kinds of text that may hold joints, or anything else."""

ARRAY_SUFFIXES = (".npy", ".c3d")

HEAD_BYTES = 16384
FEWEST_JOINTS = 8

COLUMN = re.compile(r"(?P<joint>.*\S)[\s_.:\-]+(?P<axis>[xyz])", re.IGNORECASE | re.DOTALL)
"""A column of a joint's coordinate: ``left_hip_x``, ``LeftHip.X``."""


def split_column(name: str) -> tuple[str, str] | None:
    """Joint and axis of a column's name; None where it is another kind of column."""
    found = COLUMN.fullmatch(name.strip().strip('"'))
    return (found["joint"], found["axis"].lower()) if found else None


def may_hold_joints(path: Path) -> bool:
    """Whether a csv or json file, by its first bytes, holds joint positions; never waits for a pipe."""
    if not _is_regular(path):
        return False
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError:
        return False
    text = head.decode("utf-8", "replace").lstrip("\ufeff")
    if path.suffix.lower() == ".json":
        return any(f'"{key}"' in text for key in JSON_KEYS)
    header = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    columns = [split_column(name) for name in re.split(r"[,;\t]", header)]
    axes: dict[str, set[str]] = {}
    for joint, axis in filter(None, columns):
        axes.setdefault(joint, set()).add(axis)
    return sum(found == set("xyz") for found in axes.values()) >= FEWEST_JOINTS


def is_joint_file(path: Path) -> bool:
    """Whether a file is to be read as joint positions rather than as another kind of motion."""
    suffix = path.suffix.lower()
    if suffix != ".npz":
        return suffix in (*ARRAY_SUFFIXES, *TEXT_SUFFIXES)
    if not _is_regular(path):
        return False
    try:
        names = set(array_names(path))
    except (OSError, ValueError):
        return False
    return not {"poses", "bodyPose", "pose_body", "body_pose"} & names and bool(set(POSITION_KEYS) & names)


def _is_regular(path: Path) -> bool:
    """Whether a file can be opened without waiting for someone to write into it."""
    try:
        return stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError):
        return False
