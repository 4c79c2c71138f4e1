# SPDX-License-Identifier: GPL-3.0-or-later
"""Match bones to joints on a skeleton without telling names, by chains, symmetry and positions.

Arms and legs are the two longest pairs of chains that part at one bone and have the same length; the
spine runs between the two partings, the neck beyond them. Left and right follow from sides in
the names, else from where toes and knees point.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from ..body.skeleton import JOINT_INDEX
from ..motion.source import SourceMotion

SAMPLES = 16
"""Frames looked at: lengths and directions are medians and means over them."""

ALIKE = 0.15
"""Relative difference in length up to which two chains are a pair."""

HELPERS = re.compile(r"twist|roll|share|helper|_end$|nub|ik[_.]|pole|ctrl|control", re.IGNORECASE)
"""Bones that rigs have besides the skeleton: never a joint."""

SIDES = tuple(
    (side, re.compile(rf"[{i}]{side[1:]}|{side.upper()}|(?<![A-Za-z])[{i}](?![A-Za-z0-9])"
                      rf"|(?<![A-Za-z])[{i}](?=[A-Z])(?![A-Z]_)"))
    for side, i in (("left", "lL"), ("right", "rR"))
)  # fmt: skip
"""``Left`` anywhere, or an L that stands apart or before a capital (``hip.l``, ``lHip``; not ``RL_Root``)."""

ARM_TO_LEG = (0.4, 1.15)
LEG_TO_TRUNK = (0.8, 4.0)
"""Length of the arm relative to the leg, and of the leg relative to the trunk, in people."""

SPINE = tuple(JOINT_INDEX[f"spine{number}"] for number in (1, 2, 3))
CARRIED = tuple(JOINT_INDEX[joint] for joint in ("left_shoulder", "right_shoulder", "neck", "head"))
"""Joints that the last bone of the spine carries."""

LEG = ("hip", "knee", "ankle", "foot")
ARM = ("shoulder", "elbow", "wrist", "hand")

Chain = list[int]


@dataclass(frozen=True)
class _Pair:
    """Two similar chains that part at a bone."""

    fork: int
    chains: tuple[Chain, Chain]
    length: float


def match_by_structure(source: SourceMotion) -> dict[int, int]:
    """Joint index -> bone index of an unnamed skeleton; empty if the bones are not those of a person."""
    tree = _Tree(source)
    for first, second in combinations(tree.pairs(), 2):
        matched = _as_person(tree, first, second)
        if matched:
            return matched
    return {}


def with_whole_spine(source: SourceMotion, matched: dict[int, int]) -> dict[int, int]:
    """The match of bones by name, with a spine that reaches the bone that carries neck and arms.

    Rigs number their spines as they please: if that bone lies beyond the last one that was matched,
    the three joints are spread over the bones from the pelvis to it.
    """
    parents = source.parents.tolist()
    above = [_ancestors(parents, matched[joint])[1:] for joint in CARRIED if joint in matched]
    carrier = next((bone for bone in above[0] if all(bone in line for line in above)), None)
    line = [] if carrier is None else _ancestors(parents, carrier)
    known = [matched[joint] for joint in (JOINT_INDEX["pelvis"], *SPINE) if joint in matched]
    if not set(known) <= set(line) or carrier in known:
        return matched
    spine = line[: line.index(matched[JOINT_INDEX["pelvis"]])][::-1]
    return {joint: bone for joint, bone in matched.items() if joint not in SPINE} | _spine_joints(spine)


def _ancestors(parents: Sequence[int], bone: int) -> Chain:
    """The bones from one up to its root, itself first."""
    line = [bone]
    while parents[line[-1]] >= 0:
        line.append(parents[line[-1]])
    return line


class _Tree:
    """A skeleton's bones, their children and lengths; helper bones are ignored."""

    def __init__(self, source: SourceMotion) -> None:
        frames = np.linspace(0, source.n_frames - 1, min(SAMPLES, source.n_frames)).astype(int)
        self.heads = source.matrices[frames][..., :3, 3]
        self.names = source.bones
        helper = [HELPERS.search(name) for name in source.bones]
        self.parents: list[int] = []  # past helper bones; -2 for the helpers themselves
        self.children: list[Chain] = [[] for _ in source.bones]
        for bone, parent in enumerate(source.parents.tolist()):
            while parent >= 0 and helper[parent]:
                parent = int(source.parents[parent])
            self.parents.append(-2 if helper[bone] else parent)
            if self.parents[bone] >= 0:
                self.children[parent].append(bone)
        self.reach, self._onward = self._to_leaves()

    def distance(self, a: int, b: int) -> float:
        return float(np.median(np.linalg.norm(self.heads[:, a] - self.heads[:, b], axis=1)))

    def _to_leaves(self) -> tuple[list[float], Chain]:
        """Length of the longest chain from each bone to a leaf, and the child it leads to, -1 at a leaf."""
        reach, onward = [0.0] * len(self.parents), [-1] * len(self.parents)
        for bone in reversed(range(len(self.parents))):  # children come after their parents
            for child in self.children[bone]:
                length = self.distance(bone, child) + reach[child]
                if onward[bone] < 0 or length > reach[bone]:
                    reach[bone], onward[bone] = length, child
        return reach, onward

    def longest(self, bone: int) -> Chain:
        """The longest chain from a bone to a leaf, itself first."""
        chain = [bone]
        while self._onward[chain[-1]] >= 0:
            chain.append(self._onward[chain[-1]])
        return chain

    def pairs(self) -> list[_Pair]:
        """All pairs of like chains, longest first."""
        found = []
        for fork, children in enumerate(self.children):
            chains = [self.longest(child) for child in children] if len(children) > 1 else []
            for one, other in combinations([chain for chain in chains if len(chain) >= 3], 2):
                lengths = self.reach[one[0]], self.reach[other[0]]
                starts = self.distance(fork, one[0]), self.distance(fork, other[0])
                mean = sum(lengths) / 2
                apart = abs(lengths[0] - lengths[1]) + abs(starts[0] - starts[1])
                if apart < ALIKE * mean:
                    found.append(_Pair(fork, (one, other), mean))
        return sorted(found, key=lambda pair: -pair.length)


def _as_person(tree: _Tree, a: _Pair, b: _Pair) -> dict[int, int]:
    """Joints with one pair of chains as legs and the other as arms, if people are built so."""
    legs, arms = sorted((a, b), key=lambda pair: len(_ancestors(tree.parents, pair.fork)))
    line = _ancestors(tree.parents, arms.fork)
    pelvis = next(bone for bone in _ancestors(tree.parents, legs.fork) if bone in line)
    spine = line[: line.index(pelvis)][::-1]
    if not spine or {*legs.chains[0], *legs.chains[1]} & {*arms.chains[0], *arms.chains[1], *spine}:
        return {}
    thigh, upper_arm = _limb_start(tree, legs), _limb_start(tree, arms)
    leg_bones = [chain[thigh:] for chain in legs.chains]
    arm_bones = [chain[upper_arm:] for chain in arms.chains]
    if not _human(tree, leg_bones, arm_bones):
        return {}
    collars = [chain[upper_arm - 1] if upper_arm else None for chain in arms.chains]
    if _sides_swapped(tree, leg_bones, leg_bones, arm_bones):
        leg_bones.reverse()
    if _sides_swapped(tree, arm_bones, leg_bones, arm_bones):
        arm_bones.reverse()
        collars.reverse()
    matched = {JOINT_INDEX["pelvis"]: pelvis, **_spine_joints(spine), **_head_joints(tree, arms)}
    for side, leg, arm, collar in zip(("left", "right"), leg_bones, arm_bones, collars, strict=True):
        for names, bones in ((LEG, leg), (ARM, arm)):
            matched |= {JOINT_INDEX[f"{side}_{name}"]: bone for name, bone in zip(names, bones, strict=False)}
        if collar is not None:
            matched[JOINT_INDEX[f"{side}_collar"]] = collar
    return matched


def _limb_start(tree: _Tree, pair: _Pair) -> int:
    """Place in two similar chains at which the upper arm or thigh begins.

    There two long bones follow each other, similar in length, and what comes next (a hand, a foot) is
    short; from a long collar bone on, a forearm would come next.
    """
    scores = np.zeros(min(map(len, pair.chains)) - 2)
    for chain in pair.chains:
        lengths = np.array([tree.distance(a, b) for a, b in pairwise(chain)] + [0.0])
        upper, lower, onward = lengths[:-2], lengths[1:-1], lengths[2:]
        most = np.maximum(np.maximum(upper, lower), 1e-12)
        score = (upper + lower) * np.minimum(upper, lower) / most * lower / np.maximum(lower + onward, 1e-12)
        scores += score[: len(scores)]
    return int(np.argmax(scores))


def _human(tree: _Tree, legs: list[Chain], arms: list[Chain]) -> bool:
    """Whether arms, legs and trunk have lengths that people's have."""
    arm, leg = (
        np.mean([sum(tree.distance(*limb[k : k + 2]) for k in range(2)) for limb in limbs])
        for limbs in (arms, legs)
    )
    hips, shoulders = (tree.heads[:, [limb[0] for limb in limbs]].mean(axis=1) for limbs in (legs, arms))
    trunk = np.median(np.linalg.norm(shoulders - hips, axis=1))
    return bool(
        ARM_TO_LEG[0] * leg < arm < ARM_TO_LEG[1] * leg
        and LEG_TO_TRUNK[0] * trunk < leg < LEG_TO_TRUNK[1] * trunk
    )


def _sides_swapped(tree: _Tree, limbs: list[Chain], legs: list[Chain], arms: list[Chain]) -> bool:
    """Whether the first of two limbs is the right one."""
    named = [[_named_side(tree.names[bone]) for bone in limb[:3]] for limb in limbs]
    first, second = (sides.count("left") - sides.count("right") for sides in named)
    if first * second < 0:
        return first < 0
    starts = tree.heads[:, limbs[0][0]] - tree.heads[:, limbs[1][0]]
    return float(np.sum(starts * _left(tree, legs, arms))) < 0


def _named_side(name: str) -> str:
    return next((side for side, pattern in SIDES if pattern.search(name)), "")


def _left(tree: _Tree, legs: list[Chain], arms: list[Chain]) -> np.ndarray:
    """Direction of the body's left in each frame, by its trunk and where toes and knees point."""
    heads = tree.heads
    hips, shoulders = (heads[:, [limb[0] for limb in limbs]].mean(axis=1) for limbs in (legs, arms))
    front = np.zeros_like(hips)
    for leg in legs:
        hip, knee, ankle = (heads[:, bone] for bone in leg[:3])
        front += knee - (hip + ankle) / 2
        if len(leg) > 3:
            front += heads[:, leg[3]] - ankle
    left = np.cross(shoulders - hips, front)
    return left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-12)


def _spine_joints(spine: Chain) -> dict[int, int]:
    """The three spine joints, from any number of bones between the pelvis and where the arms part."""
    names = {1: ("spine1",), 2: ("spine1", "spine3")}.get(len(spine), ("spine1", "spine2", "spine3"))
    chosen = np.linspace(0, len(spine) - 1, len(names)).round().astype(int)
    return {JOINT_INDEX[name]: spine[index] for name, index in zip(names, chosen, strict=True)}


def _head_joints(tree: _Tree, arms: _Pair) -> dict[int, int]:
    """Neck and head: the longest chain that goes on beyond the arms."""
    beyond = set(tree.children[arms.fork]) - {chain[0] for chain in arms.chains}
    if not beyond:
        return {}
    neck = max(sorted(beyond), key=lambda bone: tree.reach[bone] + tree.distance(arms.fork, bone))
    bones = [neck, *tree.children[neck][:1]]
    return {JOINT_INDEX[name]: bone for name, bone in zip(("neck", "head"), bones, strict=False)}
