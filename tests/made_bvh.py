# SPDX-License-Identifier: GPL-3.0-or-later
"""BVH files of any skeleton and any channels, and where their joints truly are, worked out one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

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
