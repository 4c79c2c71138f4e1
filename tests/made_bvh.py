# SPDX-License-Identifier: GPL-3.0-or-later
"""BVH files of any skeleton and any channels, and where their joints truly are, worked out one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import N_JOINTS, PARENTS, Y_UP_TO_Z_UP
from w2w.core.motion.skinning import joint_transforms

TO_Z_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
"""World of a BVH file, y up, to Blender's: (x, y, z) -> (x, -z, y)."""

ONE_JOINT = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  End Site
  {
    OFFSET 0 10 0
  }
}
"""
"""A skeleton of one joint, above its MOTION."""


NAMES = (
    "Hips LeftUpLeg RightUpLeg Spine LeftLeg RightLeg Spine1 LeftFoot RightFoot Spine2 LeftToeBase "
    "RightToeBase Neck LeftShoulder RightShoulder Head LeftArm RightArm LeftForeArm RightForeArm LeftHand "
    "RightHand LeftHandMiddle1 RightHandMiddle1"
).split()
"""Bones of `write_bvh`, in the order of the 24 joints."""


@dataclass(frozen=True)
class MadeJoint:
    """A joint: its parent's number (-1 of a root), its offset, its channels in their order."""

    parent: int
    offset: tuple[float, ...]
    channels: tuple[str, ...]


def draw_joints(rng: np.random.Generator, count: int, whole: bool) -> list[MadeJoint]:
    """A skeleton at random, parents before children and each child behind all that hangs on its elder.

    With `whole` as Blender's importer wants it: three rotations a joint, or none, and one root.
    """
    joints: list[MadeJoint] = []
    line: list[int] = []
    for number in range(count):
        while line and rng.random() < 0.3 and (len(line) > 1 or not whole):
            line.pop()
        turns = list(rng.permutation(["Xrotation", "Yrotation", "Zrotation"]))
        shifts = list(rng.permutation(["Xposition", "Yposition", "Zposition"]))
        if not whole:
            turns, shifts = turns[: rng.integers(0, 4)], shifts[: rng.integers(0, 4)]
        channels = [*(shifts if rng.random() < 0.4 or not line else []), *turns]
        if not whole:
            channels = list(rng.permutation(channels))
        offset = tuple(np.round(rng.normal(size=3) * 10, 6))
        joints.append(MadeJoint(line[-1] if line else -1, offset, tuple(map(str, channels))))
        line.append(number)
    return joints


def draw_values(rng: np.random.Generator, joints: list[MadeJoint], frames: int) -> np.ndarray:
    """Numbers of the frames, angles of any size."""
    channels = [name for joint in joints for name in joint.channels]
    spread = np.where([name.endswith("rotation") for name in channels], 120.0, 20.0)
    return np.round(rng.normal(size=(frames, len(channels))) * spread, 6)


def bvh_text(joints: list[MadeJoint], values: np.ndarray, frame_time: float = 1 / 60) -> str:
    """The file; joints are called ``j0``, ``j1``, ..."""
    lines = ["HIERARCHY"]

    def write(number: int) -> None:
        joint = joints[number]
        lines.append(f"{'ROOT' if joint.parent < 0 else 'JOINT'} j{number}")
        lines.extend(["{", "OFFSET " + " ".join(f"{value:.6f}" for value in joint.offset)])
        lines.append(" ".join(["CHANNELS", str(len(joint.channels)), *joint.channels]))
        children = [child for child, other in enumerate(joints) if other.parent == number]
        for child in children:
            write(child)
        if not children:
            lines.extend(["End Site", "{", "OFFSET 0 3 0", "}"])
        lines.append("}")

    for number, joint in enumerate(joints):
        if joint.parent < 0:
            write(number)
    lines += ["MOTION", f"Frames: {len(values)}", f"Frame Time: {frame_time:.9f}"]
    lines += [" ".join(f"{value:.6f}" for value in row) for row in values]
    return "\n".join(lines) + "\n"


def true_poses(joints: list[MadeJoint], values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World turns (T, B, 3, 3) and places (T, B, 3) in Blender's world, one channel after another."""
    turns = np.empty((len(values), len(joints), 3, 3))
    places = np.empty((len(values), len(joints), 3))
    for frame, row in enumerate(values):
        left = iter(row)
        for number, joint in enumerate(joints):
            turn, shift, moved = Rotation.identity(), dict.fromkeys("XYZ", 0.0), False
            for name in joint.channels:
                value = next(left)
                if name.endswith("rotation"):
                    turn = turn * Rotation.from_euler(name[0].lower(), value, degrees=True)
                else:
                    shift[name[0]], moved = value, True
            place = np.array([*shift.values()] if moved else joint.offset)
            above = (TO_Z_UP, np.zeros(3))
            if joint.parent >= 0:
                above = turns[frame, joint.parent], places[frame, joint.parent]
            turns[frame, number] = above[0] @ turn.as_matrix()
            places[frame, number] = above[1] + above[0] @ place
    return turns, places


def write_bvh(path, body, motion, folded_by=None, t_pose=True, z_up=False, scale=1.0):
    """A motion as BVH on the body's own skeleton.

    `folded_by` seeds a rotation of each bone's own axes, so that the offsets alone are no rest pose;
    0 makes the offsets z-up, whatever the motion is.
    """
    frames = motion.n_frames + t_pose
    world = np.eye(3) if z_up else Y_UP_TO_Z_UP.T
    local = np.tile(world.T if folded_by is None else np.eye(3), (N_JOINTS, 1, 1))
    if folded_by:
        local = Rotation.random(N_JOINTS, random_state=folded_by).as_matrix()
    turns, _ = joint_transforms(body, motion)
    pelvis = motion.pelvis
    if t_pose:
        turns = np.concatenate([np.tile(np.eye(3), (1, N_JOINTS, 1, 1)), turns])
        pelvis = np.concatenate([body.joints[:1], pelvis])
    turns, pelvis = world @ turns @ local, pelvis @ world.T
    angles = np.empty((frames, N_JOINTS, 3))
    for joint, parent in enumerate(PARENTS):
        relative = turns[:, joint] if parent < 0 else turns[:, parent].swapaxes(1, 2) @ turns[:, joint]
        angles[:, joint] = Rotation.from_matrix(relative).as_euler("ZXY", degrees=True)
    lines, order = ["HIERARCHY"], []

    def bone(joint, depth):
        pad = "\t" * depth
        order.append(joint)
        parent = PARENTS[joint]
        offset = np.zeros(3) if parent < 0 else local[parent].T @ (body.joints[joint] - body.joints[parent])
        lines.append(f"{pad}{'ROOT' if parent < 0 else 'JOINT'} {NAMES[joint]}")
        lines.append(pad + "{")
        lines.append(f"{pad}\tOFFSET " + " ".join(f"{scale * value:.6f}" for value in offset))
        position = "Xposition Yposition Zposition " if parent < 0 else ""
        channels = 6 if parent < 0 else 3
        lines.append(f"{pad}\tCHANNELS {channels} {position}Zrotation Xrotation Yrotation")
        children = [child for child in range(N_JOINTS) if PARENTS[child] == joint]
        for child in children:
            bone(child, depth + 1)
        if not children:
            lines.extend([pad + "\tEnd Site", pad + "\t{", pad + "\t\tOFFSET 0 0.05 0", pad + "\t}"])
        lines.append(pad + "}")

    bone(0, 0)
    lines += ["MOTION", f"Frames: {frames}", f"Frame Time: {1 / motion.rate:.8f}"]
    for place, row in zip(pelvis, angles, strict=True):
        values = [*(scale * place), *row[order].ravel()]
        lines.append(" ".join(f"{value:.6f}" for value in values))
    path.write_text("\n".join(lines) + "\n")
