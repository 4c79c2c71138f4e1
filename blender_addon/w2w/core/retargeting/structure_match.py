# SPDX-License-Identifier: GPL-3.0-or-later
"""Match bones to joints on a skeleton without telling names, by chains, symmetry and positions.

Arms and legs are the two pairs of chains that part at one bone and have the same length which are most like a
person's; the spine runs between the two partings, the neck beyond them. Left and right follow from sides in
the names, else from where toes and knees point.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from operator import itemgetter

import numpy as np

from ..body.body import JOINT_INDEX
from ..motion.source import SourceMotion, unscaled_rotations
from ..rotations import unit
from .limb_joints import ARM_BUILD, LEG_BUILD, MOST_COST, Joints, Limb, limb_joints

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

MOST_BONES = 12
"""Bones of a limb that are looked at."""

LONGEST = 8
"""Pairs of chains among which arms and legs are sought: hands have many more, of fingers."""

SHOWN = 0.02
"""How far knees and toes are in front of a leg, of its length, to show where the front is."""

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
    """Joint index -> bone index of an unnamed skeleton; {} if its bones are no person's, or it is unclear."""
    tree = _Tree(source)
    pairs = combinations(tree.pairs()[:LONGEST], 2)
    people = [person for pair in pairs if (person := _as_person(tree, *pair)) is not None]
    cost, matched = min(people, key=itemgetter(0), default=(np.inf, {}))
    return matched if cost <= MOST_COST else {}


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
        rotations = unscaled_rotations(source.matrices[frames])
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
        self.turns = _widest(rotations[:, np.maximum(self.parents, 0)].swapaxes(-1, -2) @ rotations)

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

    def limbs(self, pair: _Pair) -> list[Limb]:
        """Both limbs of a pair, as long as the shorter one, without what no limb has."""
        length = min(MOST_BONES, *map(len, pair.chains))
        both = ([pair.fork, *chain[:length]] for chain in pair.chains)
        return [Limb(self.heads[:, bones], self.turns[bones]) for bones in both]

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


def _widest(turns: np.ndarray) -> np.ndarray:
    """Degrees (B,) from the mean of rotations (T, B, 3, 3) to the one that is farthest from it."""
    left, _, right = np.linalg.svd(turns.mean(axis=0))
    cosines = (np.einsum("tbij,bij->tb", turns, left @ right) - 1) / 2
    return np.degrees(np.arccos(np.clip(cosines, -1, 1))).max(axis=0)


def _as_person(tree: _Tree, a: _Pair, b: _Pair) -> tuple[float, dict[int, int]] | None:
    """Joints with one pair of chains as legs and the other as arms, and what speaks against it.

    None if they cannot be, and no joints if it is unclear which they are.
    """
    legs, arms = sorted((a, b), key=lambda pair: len(_ancestors(tree.parents, pair.fork)))
    line = _ancestors(tree.parents, arms.fork)
    pelvis = next((bone for bone in _ancestors(tree.parents, legs.fork) if bone in line), -1)
    spine = line[: line.index(pelvis)][::-1] if pelvis >= 0 else []
    if not spine or {*legs.chains[0], *legs.chains[1]} & {*arms.chains[0], *arms.chains[1], *spine}:
        return None
    trunk = tree.distance(pelvis, arms.fork)
    thigh, leg_cost, legs_are_clear = limb_joints(tree.limbs(legs), LEG_BUILD, trunk)
    leg_bones = [_at(tree, chain, thigh) for chain in legs.chains]
    length = float(np.mean([tree.distance(*leg[k : k + 2]) for leg in leg_bones for k in range(2)])) * 2
    upper_arm, arm_cost, arms_are_clear = limb_joints(tree.limbs(arms), ARM_BUILD, length)
    arm_bones = [_at(tree, chain, upper_arm) for chain in arms.chains]
    collars = [chain[upper_arm[0] - 1] if upper_arm[0] else None for chain in arms.chains]
    left = _left(tree, leg_bones, arm_bones, length)
    swapped = [_is_right(tree, limbs, left) for limbs in (leg_bones, arm_bones)]
    if not (legs_are_clear and arms_are_clear) or None in swapped:
        return leg_cost + arm_cost, {}
    if swapped[0]:
        leg_bones.reverse()
    if swapped[1]:
        arm_bones.reverse()
        collars.reverse()
    matched = {JOINT_INDEX["pelvis"]: pelvis, **_spine_joints(spine), **_head_joints(tree, arms)}
    for side, leg, arm, collar in zip(("left", "right"), leg_bones, arm_bones, collars, strict=True):
        for names, bones in ((LEG, leg), (ARM, arm)):
            matched |= {JOINT_INDEX[f"{side}_{name}"]: bone for name, bone in zip(names, bones, strict=False)}
        if collar is not None:
            matched[JOINT_INDEX[f"{side}_collar"]] = collar
    return leg_cost + arm_cost, matched


def _at(tree: _Tree, chain: Chain, joints: Joints) -> Chain:
    """The bones of a limb's joints, and the one after them: of several fingers that in the middle."""
    bones, after = [chain[place] for place in joints], chain[joints[2] + 1 : joints[2] + 2]
    if len(fingers := tree.children[bones[-1]]) > 2:
        heads = tree.heads[:, fingers]
        aside = np.linalg.norm(heads - np.median(heads, axis=1, keepdims=True), axis=-1).mean(axis=0)
        after = [fingers[int(aside.argmin())]]
    return bones + after


def _is_right(tree: _Tree, limbs: list[Chain], left: np.ndarray) -> bool | None:
    """Whether the first of two limbs is the right one; None where neither names nor the front show it."""
    named = [[_named_side(tree.names[bone]) for bone in limb[:3]] for limb in limbs]
    first, second = (sides.count("left") - sides.count("right") for sides in named)
    if first * second < 0:
        return first < 0
    starts = unit(tree.heads[:, limbs[0][0]] - tree.heads[:, limbs[1][0]])
    shown = float((starts * left).sum(axis=1).mean())
    return None if abs(shown) < SHOWN else shown < 0


def _named_side(name: str) -> str:
    return next((side for side, pattern in SIDES if pattern.search(name)), "")


def _left(tree: _Tree, legs: list[Chain], arms: list[Chain], length: float) -> np.ndarray:
    """Direction (T, 3) of the body's left, by its trunk and where toes and knees point.

    Its length says how far they do, of the leg's `length`.
    """
    heads = tree.heads
    hips, shoulders = (heads[:, [limb[0] for limb in limbs]].mean(axis=1) for limbs in (legs, arms))
    front = np.zeros_like(hips)
    for leg in legs:
        hip, knee, ankle = (heads[:, bone] for bone in leg[:3])
        front += knee - (hip + ankle) / 2
        if len(leg) > 3:
            front += heads[:, leg[3]] - ankle
    return np.cross(unit(shoulders - hips), front / max(2 * length, 1e-12))


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
