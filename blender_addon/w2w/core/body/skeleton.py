# SPDX-License-Identifier: GPL-3.0-or-later
"""The 24-joint SMPL skeleton: joint names, parents, the turn from y-up to z-up, and lengths of a body."""

from collections.abc import Mapping

import numpy as np

JOINT_NAMES: tuple[str, ...] = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle",
    "right_ankle", "spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head",
    "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
    "left_hand", "right_hand",
)  # fmt: skip
"""Joint order of SMPL (Loper et al. 2015), named as in the smplx package."""

PARENTS: tuple[int, ...] = (
    -1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21,
)  # fmt: skip
"""Parent of each joint; -1 for the root. Parents always come before their children."""

N_JOINTS = len(JOINT_NAMES)
BODY_HANDS = (22, 23)
"""SMPL's hand joints, which SMPL-H and SMPL-X replace by fingers."""

JOINT_INDEX: dict[str, int] = {name: index for index, name in enumerate(JOINT_NAMES)}

_OTHER_SIDE = {"left": "right", "right": "left"}
MIRRORED_JOINTS: tuple[int, ...] = tuple(
    JOINT_INDEX["_".join(_OTHER_SIDE.get(word, word) for word in name.split("_"))] for name in JOINT_NAMES
)
"""Index of the joint on the other side of the body (a middle joint is its own mirror)."""

Y_UP_TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation that turns SMPL's y-up axes to Blender's z-up axes: (x, y, z) -> (x, -z, y)."""

LEG = ("hip", "knee", "ankle")


def posed_joints(rest: np.ndarray, turns: np.ndarray, pelvis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forward kinematics: world rotations (T, 24, 3, 3) and positions (T, 24, 3) of the joints.

    `rest` (24, 3) are their places in the rest pose, `turns` (T, 24, 3, 3) are relative to their parents.
    """
    rotations = np.empty_like(turns)
    positions = np.empty((len(turns), N_JOINTS, 3))
    rotations[:, 0] = turns[:, 0]
    positions[:, 0] = pelvis
    for joint in range(1, N_JOINTS):
        parent = PARENTS[joint]
        np.matmul(rotations[:, parent], turns[:, joint], out=rotations[:, joint])
        positions[:, joint] = positions[:, parent] + rotations[:, parent] @ (rest[joint] - rest[parent])
    return rotations, positions


Joints = Mapping[int, np.ndarray] | np.ndarray
"""Positions (..., 3) of joints by their index."""


def midpoint(joints: Joints, part: str) -> np.ndarray:
    """The point halfway between left and right."""
    return (joints[JOINT_INDEX[f"left_{part}"]] + joints[JOINT_INDEX[f"right_{part}"]]) / 2


def trunk_line(joints: Joints) -> np.ndarray:
    """The vector from between the hips to between the shoulders."""
    return midpoint(joints, "shoulder") - midpoint(joints, "hip")


def limb_length(joints: Joints, parts: tuple[str, ...] = LEG) -> float:
    """Mean length of the two limbs over some joints, each position (3,)."""
    limbs = [[joints[JOINT_INDEX[f"{side}_{part}"]] for part in parts] for side in ("left", "right")]
    return float(np.linalg.norm(np.diff(np.array(limbs), axis=1), axis=-1).sum() / 2)
