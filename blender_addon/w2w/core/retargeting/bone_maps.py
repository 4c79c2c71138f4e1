# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the bones of a named skeleton that play the 24 joints."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from ..body.body import JOINT_INDEX, JOINT_NAMES, TEMPLATES

BONE_MAPS = TEMPLATES / "bone_maps"

REQUIRED_JOINTS: tuple[str, ...] = (
    "pelvis", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle",
    "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
"""Joints without which a motion cannot be retargeted to the body."""

SHARED = 0.8
"""Part of the bones: a prefix or suffix that more of them have says nothing and is left out."""

OFTEN = len(REQUIRED_JOINTS)
"""Bones that a prefix or suffix may be of as well: rigs have others than those that deform."""

PREFIX = re.compile(r"[A-Za-z]+\d+(?=[A-Z])|[^-_. ]+[-_. ]+")
SUFFIX = re.compile(r"[-_. ]+[^-_. ]+$")
WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
SIDES = {"l": "left", "lft": "left", "left": "left", "r": "right", "rgt": "right", "right": "right"}
"""Words that say the side, at either end of a name."""


@dataclass(frozen=True)
class BoneMap:
    """Names of the bones of one family of rigs."""

    name: str  # what people call the family: "Mixamo"
    # joint -> bones that play it, best first
    joints: dict[str, tuple[str, ...]]

    @classmethod
    def load(cls, path: str | Path) -> BoneMap:
        """Read a bone map: JSON with ``name`` and ``joints`` (joint name to bone names).

        A ValueError names the file and its fault.
        """
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
            joints = {
                joint: tuple(map(str.strip, [names] if isinstance(names, str) else names))
                for joint, names in content["joints"].items()
            }
            name = str(content["name"])
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            why = f"{path} is not a bone map (JSON with 'name' and 'joints'): {error!r}"
            raise ValueError(why) from error
        unknown = set(joints) - set(JOINT_NAMES)
        if unknown:
            raise ValueError(f"{path} names joints that SMPL does not have: {', '.join(sorted(unknown))}")
        return cls(name, joints)

    def match(self, bones: Sequence[str]) -> dict[int, int]:
        """Joint index -> bone index, for the joints whose bone is there."""
        position = _positions(tuple(bones))
        matched = {}
        for joint, names in self.joints.items():
            bone = next((position[name] for name in _forms(names) if name in position), None)
            if bone is not None:
                matched[JOINT_INDEX[joint]] = bone
        return matched

    def written(self, plain: Container[str]) -> int:
        """How many joints have a bone among some plain names without more ado."""
        return sum(any(plain_name(name) in plain for name in names) for names in self.joints.values())


Match = tuple[BoneMap | None, dict[int, int]]
"""A bone map and what it matches: joint index -> bone index."""


@lru_cache(maxsize=64)
def _positions(bones: tuple[str, ...]) -> dict[str, int]:
    """Number of the bone of each plain name; cached, as the clips of a library have few skeletons."""
    position: dict[str, int] = {}
    for names in _readings(bones):
        for write in (plain_name, side_first):
            for index, name in enumerate(names):
                if plain := write(name):
                    position.setdefault(plain, index)
    return position


@lru_cache(maxsize=4096)
def _forms(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names as `plain_name` writes them, then as `side_first` does."""
    return tuple(dict.fromkeys([*map(plain_name, names), *map(side_first, names)]))


@lru_cache(maxsize=4096)
def plain_name(name: str) -> str:
    """A bone's name without name space, case and separators: ``mixamorig:LeftArm`` -> ``leftarm``."""
    return re.sub(r"[^0-9a-z]", "", _local(name).lower())


@lru_cache(maxsize=4096)
def side_first(name: str) -> str:
    """A bone's plain name with its side, where one is at an end, in front: ``Arm_L`` -> ``leftarm``."""
    words, plain = WORDS.findall(_local(name)), plain_name(name)
    for place in (0, -1):
        if len(words) > 1 and (side := SIDES.get(words[place].lower())):
            return side + "".join(words[1:] if place == 0 else words[:-1]).lower()
    side = next((side for side in ("left", "right") if plain.endswith(side)), "")
    return side + plain.removesuffix(side)


def _local(name: str) -> str:
    """A bone's name without name space."""
    return re.sub(r"^mixamorig\d*[_ ]?", "", re.sub(r"^.*[:|]", "", name), flags=re.IGNORECASE)


def _readings(bones: Sequence[str]) -> list[list[str]]:
    """Names of all bones, first without what most of them begin or end with (``Neo_Hips``, ``Hips_jnt``).

    Then as they are, and last those that have what many begin or end with, without it; others are empty.
    """
    names = [_local(name) for name in bones]
    readings = [names]
    while (affix := next(_affixes(names, SHARED * len(names)), "")) and len(readings) <= len(names):
        names = [name.removeprefix(affix).removesuffix(affix) for name in names]
        readings.insert(0, names)
    for affix in _affixes(names, OFTEN - 1):
        without = [name.removeprefix(affix).removesuffix(affix) for name in names]
        readings.append([new if new != old else "" for new, old in zip(without, names, strict=True)])
    return readings


def _affixes(names: Sequence[str], least: float) -> Iterator[str]:
    """What more than so many names begin or end with, the commonest first, but for sides."""
    found = [match[0] for name in names for match in (SUFFIX.search(name), PREFIX.match(name)) if match]
    for affix, uses in Counter(found).most_common():
        if uses > least and plain_name(affix) not in SIDES:
            yield affix


@cache
def bundled_bone_maps() -> tuple[BoneMap, ...]:
    """The bone maps that come with W2W."""
    return tuple(BoneMap.load(path) for path in sorted(BONE_MAPS.glob("*.json")))


def best_match(bones: Sequence[str], maps: Iterable[BoneMap] = ()) -> tuple[BoneMap | None, dict[int, int]]:
    """The bone map that finds most joints of a skeleton, and its match: joint index -> bone index.

    A map of the user's own that finds all required joints goes before the bundled ones. None if no map
    finds a single joint.
    """
    own = _best((bone_map, bone_map.match(bones)) for bone_map in maps)
    best, matched = _best([own, _best_bundled(tuple(bones))]) if missing_joints(own[1]) else own
    return best, dict(matched)


@lru_cache(maxsize=64)
def _best_bundled(bones: tuple[str, ...]) -> Match:
    """The best of the bundled maps; the clips of a library have few different skeletons."""
    matches = ((bone_map, bone_map.match(bones)) for bone_map in bundled_bone_maps())
    return _best(matches, set(map(plain_name, bones)))


def _best(matches: Iterable[Match], plain: Container[str] = ()) -> Match:
    """The first map that finds most required joints, then most others; None if none finds any.

    Equally good maps differ by how many names they have among some, then by how much of the spine.
    """

    def rank(match: Match) -> tuple[int, int, int, int]:
        apart = sum(not JOINT_NAMES[joint].startswith("spine") for joint in match[1])
        written = match[0].written(plain) if match[0] else 0
        return -len(missing_joints(match[1])), apart, written, len(match[1])

    return max([(None, {}), *matches], key=rank)


def missing_joints(matched: dict[int, int]) -> list[str]:
    """Required joints that a match lacks."""
    return [name for name in REQUIRED_JOINTS if JOINT_INDEX[name] not in matched]
