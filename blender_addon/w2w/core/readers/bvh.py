# SPDX-License-Identifier: GPL-3.0-or-later
"""BVH files as motions: the joints' channels as world matrices, z up."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..motion.sight import Up
from ..motion.source import TO_Z_UP, SourceMotion, UnusableMotion, people_in, refuse_pose
from ..motion.up import BY_ITSELF, Ups
from ..retargeting.repair import repaired
from ..wording import clean
from .bvh_text import BvhText, digest_of, read_bvh_text

BVH_SUFFIX = ".bvh"

LEAST_TURN = 0.1
"""Angles below it, in any unit, are a skeleton that is moved by positions, or still."""


def read_bvh(
    path: Path, rate: float | None = None, up: Up | None = None, ups: Ups = BY_ITSELF
) -> SourceMotion:
    """Read a BVH file: z up, in its own unit, without T-poses at its ends, at rest as a person can be.

    `rate` and the axis `up` go before the file's own; `ups` are the axes of its library.

    Raises UnusableMotion, with the reason, if the file cannot be used.
    """
    text = read_bvh_text(path, rate)
    _refuse_radians(text)
    motion = as_it_stands(text, clean(path.stem))
    refuse_pose(motion)
    return repaired(motion, up, ups)


def _refuse_radians(text: BvhText) -> None:
    """Refuse angles in which no joint but a root ever turns as far as a body does in any motion."""
    inner = [
        joint.parent >= 0 and name.endswith("rotation") for joint in text.joints for name in joint.channels
    ]
    widest = np.abs(text.values[:, inner]).max(initial=0.0)
    if LEAST_TURN < widest <= 2 * np.pi:
        raise UnusableMotion(
            f"its joints turn by up to {widest:.2g} degrees: its angles look like radians: multiply all of "
            "its rotations by 180 / pi"
        )


def as_it_stands(text: BvhText, take: str) -> SourceMotion:
    """The motion as the file has it: the offsets are the rest pose, the y axis is up, every frame counts."""
    joints = text.joints
    local_rest, local = np.tile(np.eye(4), (len(joints), 1, 1)), _local_matrices(text)
    local_rest[:, :3, 3] = [joint.offset for joint in joints]
    rest, matrices = np.empty_like(local_rest), np.empty_like(local)
    for number, joint in enumerate(joints):
        root = joint.parent < 0
        rest[number] = (TO_Z_UP if root else rest[joint.parent]) @ local_rest[number]
        np.matmul(TO_Z_UP if root else matrices[:, joint.parent], local[:, number], out=matrices[:, number])
    parents = np.array([joint.parent for joint in joints])
    names = tuple(joint.name for joint in joints)
    found = SourceMotion(names, parents, rest, matrices, text.rate, take, people_in(parents))
    return replace(found, skeleton=digest_of(joints))


def _local_matrices(text: BvhText) -> np.ndarray:
    """Matrix of each joint against its parent, shape (T, B, 4, 4).

    A joint's first rotation channel turns last, and positions replace its offset.
    """
    local = np.zeros((len(text.values), len(text.joints), 4, 4))
    local[..., 3, 3] = 1
    local[..., :3, :3] = np.eye(3)
    turning: dict[str, list[tuple[int, list[int]]]] = {}
    shifts: list[tuple[int, int, int]] = []  # joint, axis and column
    start = 0
    for number, joint in enumerate(text.joints):
        columns = {name: start + place for place, name in enumerate(joint.channels)}
        start += len(columns)
        moved = [(number, "xyz".index(name[0]), at) for name, at in columns.items() if "position" in name]
        if not moved:
            local[:, number, :3, 3] = joint.offset
        shifts += moved
        turns = {name: column for name, column in columns.items() if name.endswith("rotation")}
        if turns:
            order = "".join(name[0] for name in turns)
            turning.setdefault(order, []).append((number, list(turns.values())))
    if shifts:
        numbers, axes, places = map(list, zip(*shifts, strict=True))
        local[:, numbers, axes, 3] = text.values[:, places]
    for order, those in turning.items():  # all joints of one order at once: there are few orders
        numbers, angles = map(list, zip(*those, strict=True))
        local[:, numbers, :3, :3] = _turns(order, text.values[:, angles])
    return local


def _turns(order: str, degrees: np.ndarray) -> np.ndarray:
    """Rotation matrices (T, J, 3, 3) from angles (T, J, axes) about axes that turn along, such as ``zxy``."""
    angles = np.radians(degrees).transpose(2, 1, 0)
    turns = np.zeros((3, 3, *angles.shape[1:]))  # entry by entry: whole ones are quick to work on
    turns[range(3), range(3)] = 1
    for axis, cosine, sine in zip(order, np.cos(angles), np.sin(angles), strict=True):
        after, before = ("xyz".index(axis) + 1) % 3, ("xyz".index(axis) + 2) % 3
        a, b = turns[:, after], turns[:, before]
        turns[:, after], turns[:, before] = cosine * a + sine * b, cosine * b - sine * a
    return turns.transpose(3, 2, 0, 1)
