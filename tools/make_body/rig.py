# SPDX-License-Identifier: GPL-3.0-or-later
"""MakeHuman's rig brought to SMPL's: 24 joints, grouped weights, and the turn from A-pose to T-pose.

The rotations into the T-pose are found once, on the neutral body, and then kept for every
shape. With fixed rotations and weights the posed vertices and joints are linear in the
A-pose vertices, so a shape target stays an exact, linear displacement in the T-pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS

CUBES: dict[str, tuple[str, ...]] = {
    "pelvis": ("pelvis", "spine-4"),
    "spine1": ("spine-3",),
    "spine2": ("spine-2",),
    "spine3": ("spine-1",),
    "neck": ("neck",),
    "head": ("head",),
    "hip": ("upper-leg",),
    "knee": ("knee",),
    "ankle": ("ankle",),
    "foot": ("toe-1-1", "toe-2-1", "toe-3-1", "toe-4-1", "toe-5-1"),
    "collar": ("clavicle",),
    "shoulder": ("shoulder",),
    "elbow": ("elbow",),
    "wrist": ("hand",),
    "hand": ("finger-2-1", "finger-3-1", "finger-4-1", "finger-5-1"),
}
"""Joint cubes of MakeHuman whose mean centre is the joint (`l-` or `r-` in front on the sides)."""

BONES: dict[str, tuple[str, ...]] = {
    "pelvis": ("root", "pelvis", "spine05", "spine04"),
    "spine1": ("spine03",),
    "spine2": ("spine02",),
    "spine3": ("spine01",),
    "neck": ("neck",),
    "hip": ("upperleg",),
    "knee": ("lowerleg",),
    "ankle": ("foot",),
    "foot": ("toe",),
    "collar": ("clavicle", "shoulder01"),
    "shoulder": ("upperarm",),
    "elbow": ("lowerarm",),
    "wrist": ("wrist", "metacarpal", "finger1"),
    "hand": ("finger2", "finger3", "finger4", "finger5"),
}
"""Bones of MakeHuman's default rig, by the start of their names, that each joint carries.

The thumb stays with the wrist: it does not turn about the knuckles. Bones of the face and
all others go to the head.
"""

UNUSED_BONES = "breast"
"""Bones that no joint carries: the others that hold their vertices share their weight."""

COLLAR_RAISE = np.deg2rad(15.0)
"""How far the collar bone rises while the arm goes from MakeHuman's A-pose to the T-pose."""

LEG_SPREAD = np.deg2rad(4.0)
"""Angle of the T-pose's legs to the vertical: slightly apart, so that heavy thighs do not meet."""


def joint_positions(vertices: np.ndarray, cubes: dict[str, np.ndarray]) -> np.ndarray:
    """Positions of the 24 joints: means of the joint cubes, so linear in the vertices; shape (24, 3)."""
    joints = np.empty((N_JOINTS, 3))
    for index, name in enumerate(JOINT_NAMES):
        side, _, part = name.rpartition("_")
        prefix = "joint-" + (f"{side[0]}-" if side else "")
        centres = [vertices[cubes[prefix + cube]].mean(axis=0) for cube in CUBES[part]]
        joints[index] = np.mean(centres, axis=0)
    return joints


def group_weights(bones: tuple[str, ...], weights: np.ndarray) -> np.ndarray:
    """Weights of the 163 bones summed into those of the 24 joints, shape (V, 24)."""
    grouped = np.zeros((len(weights), N_JOINTS))
    for column, bone in enumerate(bones):
        if not bone.startswith(UNUSED_BONES):
            grouped[:, _joint_of_bone(bone)] += weights[:, column]
    return grouped / grouped.sum(axis=1, keepdims=True)


def _joint_of_bone(bone: str) -> int:
    name, _, side = bone.partition(".")
    for part, starts in BONES.items():
        if name.startswith(starts):
            sided = {"L": f"left_{part}", "R": f"right_{part}"}.get(side, part)
            return JOINT_INDEX.get(sided, JOINT_INDEX.get(part, -1))
    return JOINT_INDEX["head"]


@dataclass(frozen=True)
class TPose:
    """World rotations, one a joint, that turn MakeHuman's A-pose into the T-pose.

    Parameters
    ----------
    rotations : ndarray, shape (24, 3, 3)
    """

    rotations: np.ndarray

    @classmethod
    def of(cls, joints: np.ndarray, knuckles: np.ndarray) -> TPose:
        """Rotations for a body.

        Parameters
        ----------
        joints : ndarray, shape (24, 3)
            Joints in the A-pose.
        knuckles : ndarray, shape (3,)
            From the left index finger's base to the little finger's.
        """
        at = {name: joints[index] for index, name in enumerate(JOINT_NAMES)}
        upper, fore = at["left_elbow"] - at["left_shoulder"], at["left_wrist"] - at["left_elbow"]
        hinge = np.cross(upper, fore)
        x, y, z = np.eye(3)
        leg = np.array([np.sin(LEG_SPREAD), 0.0, -np.cos(LEG_SPREAD)])
        left = {
            "collar": Rotation.from_rotvec(-COLLAR_RAISE * y).as_matrix(),
            "shoulder": _turn(upper, hinge, x, -z),
            "elbow": _turn(fore, hinge, x, -z),
            "wrist": _turn(at["left_hand"] - at["left_wrist"], knuckles, x, y),
            "hip": _turn(at["left_knee"] - at["left_hip"], x, leg, x),
            "knee": _turn(at["left_ankle"] - at["left_knee"], x, leg, x),
        }
        left["hand"] = left["wrist"]
        rotations = np.tile(np.eye(3), (N_JOINTS, 1, 1))
        flip = np.diag([-1.0, 1.0, 1.0])
        for part, rotation in left.items():
            rotations[JOINT_INDEX[f"left_{part}"]] = rotation
            rotations[JOINT_INDEX[f"right_{part}"]] = flip @ rotation @ flip
        return cls(rotations)

    def apply(
        self, vertices: np.ndarray, joints: np.ndarray, weights: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and joints in the T-pose; linear in both arguments."""
        posed = joints.copy()
        for joint in range(1, N_JOINTS):
            parent = PARENTS[joint]
            posed[joint] = posed[parent] + self.rotations[parent] @ (joints[joint] - joints[parent])
        offsets = posed - np.einsum("jab,jb->ja", self.rotations, joints)
        turned = np.einsum("vj,jab,vb->va", weights, self.rotations, vertices, optimize=True)
        return turned + weights @ offsets, posed


def _turn(first: np.ndarray, second: np.ndarray, to_first: np.ndarray, to_second: np.ndarray) -> np.ndarray:
    """Rotation that takes `first` onto `to_first` and the plane of both onto the target's plane."""
    return _frame(to_first, to_second).T @ _frame(first, second)


def _frame(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    first = first / np.linalg.norm(first)
    second = second - first * (first @ second)
    second /= np.linalg.norm(second)
    return np.stack([first, second, np.cross(first, second)])
