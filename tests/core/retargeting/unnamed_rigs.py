# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons of many builds that move as people do, whose bones' names say nothing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, Body
from w2w.core.motion.source import SourceMotion

SIDES = (("left", 1.0), ("right", -1.0))

COLLARS = (0.02, 0.05, 0.1, 0.14, 0.19, 0.22, 0.25)
"""Metres from where the collar begins to the shoulder, which is further out where the chest is too narrow."""


@dataclass
class _Bones:
    """Bones as they are added, each after its parent."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    heads: list[np.ndarray] = field(default_factory=list)

    def add(self, name: str, parent: int, head: np.ndarray) -> int:
        self.names.append(name)
        self.parents.append(parent)
        self.heads.append(head)
        return len(self.names) - 1

    def limb(self, side: str, parts: list[str], heads: list[np.ndarray], parent: int, twists: str) -> int:
        """Bones from joint to joint, those for the twist in line with them or hanging on them."""
        for part, head, end in zip(parts, heads, [*heads[1:], None], strict=True):
            parent = bone = self.add(f"{side}_{part}", parent, head)
            if end is not None and twists:
                twist = self.add(f"{side}_{part} twist", bone, (head + end) / 2)
                parent = twist if twists == "in line" else bone
        return parent


def unnamed_rig(body: Body, seed: int) -> tuple[SourceMotion, dict[int, int]]:
    """A skeleton of drawn build, 40 frames of it, and the bone of each of the joints that it has."""
    rng = np.random.default_rng(seed)
    bones = _Bones()
    twists = str(rng.choice(["", "", "hanging", "arms", "in line"]))
    top = bones.add("pelvis", -1, _at(body, "pelvis"))
    spine = _at(body, "spine1") + np.linspace(0, 1, rng.integers(2, 7))[:, None] * (
        _at(body, "spine3") - _at(body, "spine1")
    )
    for number, head in enumerate(spine):
        top = bones.add(f"back {number}", top, head)
    neck = bones.add("neck", top, _at(body, "neck"))
    bones.add("head", neck, _at(body, "head"))
    collar, n_collars, n_fingers = rng.choice(COLLARS), rng.integers(3), rng.choice([0, 1, 5])
    upper, fore, hand, leg = (
        rng.uniform(*limits) for limits in ((0.75, 1.2), (0.75, 1.2), (0.6, 1.9), (0.85, 1.12))
    )
    has_toes = rng.random() < 0.7
    for side, sign in SIDES if rng.random() < 0.5 else SIDES[::-1]:
        arm = [_at(body, f"{side}_{part}") for part in ("shoulder", "elbow", "wrist", "hand")]
        inner = 0.02 * sign if collar >= abs(arm[0][0]) - 0.02 else arm[0][0] - sign * collar
        start = np.array([inner, *arm[0][1:]])
        ways = np.diff(arm, axis=0) * np.array([upper, fore, hand])[:, None]
        heads = start + np.cumsum([[sign * collar, 0, 0], *ways], axis=0)
        parent = top
        for number in range(n_collars):
            parent = bones.add(
                f"{side} collar {number}", parent, start + (heads[0] - start) * number / n_collars
            )
        in_arms = "in line" if twists == "arms" else twists
        wrist = bones.limb(side, ["shoulder", "elbow", "wrist"], list(heads[:3]), parent, in_arms)
        for finger in range(n_fingers):
            parent = wrist
            for number in range(3):
                aside = [sign * 0.035 * number, 0.02 * (finger - n_fingers // 2), 0]
                parent = bones.add(f"{side} finger", parent, heads[3] + aside)
        legs = [_at(body, f"{side}_{part}") for part in ("hip", "knee", "ankle", "foot")]
        ways = np.diff(legs, axis=0) * np.array([leg, leg, 1])[:, None]
        heads = legs[0] + np.cumsum([np.zeros(3), *ways], axis=0)
        in_legs = "" if twists == "arms" else twists
        ankle = bones.limb(side, ["hip", "knee", "ankle"], list(heads[:3]), 0, in_legs)
        if has_toes:
            bones.add(f"{side}_foot", ankle, heads[3])
    source = _moved(bones, str(rng.choice(["arms still", "walk", "wave", "all"])), bool(rng.random() < 0.5))
    joints = {JOINT_INDEX[name]: number for number, name in enumerate(bones.names) if name in JOINT_INDEX}
    return source, joints


def _at(body: Body, joint: str) -> np.ndarray:
    return body.joints[JOINT_INDEX[joint]]


def _moved(bones: _Bones, way: str, arms_lowered: bool) -> SourceMotion:
    """Two seconds in which the limbs turn as `way` says."""
    time = np.arange(40) / 20
    swing = np.sin(2 * np.pi * time)
    turns = np.tile(np.eye(3), (len(time), len(bones.names), 1, 1))

    def turn(name: str, axis: list[float], degrees: np.ndarray | float) -> None:
        for bone in (number for number, its_name in enumerate(bones.names) if its_name == name):
            angles = np.radians(degrees) * np.ones(len(time))
            turns[:, bone] = Rotation.from_rotvec(np.outer(angles, axis)).as_matrix() @ turns[:, bone]

    for side, sign in SIDES:
        turn(f"{side}_shoulder", [0, 1, 0], sign * 70 * (arms_lowered or way != "arms still"))
        if way == "walk":
            turn(f"{side}_shoulder", [1, 0, 0], sign * 25 * swing)
            turn(f"{side}_elbow", [0, 0, 1], -sign * (20 + 15 * swing))
        if way in ("wave", "all"):
            turn(f"{side}_shoulder", [0, 1, 0], -sign * (40 + 40 * np.sin(3 * time + sign)))
            turn(f"{side}_elbow", [0, 0, 1], -sign * (50 + 45 * np.sin(4 * time)))
            turn(f"{side}_wrist", [0, 1, 0], 20 * np.sin(5 * time))
            turn(f"{side} collar 0", [0, 1, 0], -sign * (6 + 6 * np.sin(3 * time + sign)))
        if way != "wave":
            turn(f"{side}_hip", [1, 0, 0], -sign * 25 * swing)
            turn(f"{side}_knee", [1, 0, 0], 20 + 20 * np.sin(2 * np.pi * time + sign))
            turn(f"{side}_ankle", [1, 0, 0], 10 * swing)
    matrices = np.tile(np.eye(4), (len(time), len(bones.names), 1, 1))
    for bone, parent in enumerate(bones.parents):
        base = matrices[:, parent] if parent >= 0 else np.eye(4)
        shift = bones.heads[bone] - (bones.heads[parent] if parent >= 0 else 0)
        matrices[:, bone, :3, :3] = base[..., :3, :3] @ turns[:, bone]
        matrices[:, bone, :3, 3] = base[..., :3, 3] + base[..., :3, :3] @ shift
    rest = np.tile(np.eye(4), (len(bones.names), 1, 1))
    rest[:, :3, 3] = bones.heads
    names = tuple(f"bone_{number:02}" for number in range(len(bones.names)))
    return SourceMotion(names, np.array(bones.parents), rest, matrices, 20.0)
