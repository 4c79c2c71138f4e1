# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the bones of a named skeleton that play the 24 joints."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from ..body.body import TEMPLATES
from ..body.skeleton import JOINT_INDEX, JOINT_NAMES

BONE_MAPS = TEMPLATES / "bone_maps"

REQUIRED_JOINTS: tuple[str, ...] = (
    "pelvis", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle",
    "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
"""Joints without which a motion cannot be retargeted to the body."""

SHARED_PREFIX = 0.8
"""A prefix that more than this share of the bones have says nothing and is left out."""


@dataclass(frozen=True)
class BoneMap:
    """Names of the bones of one family of rigs."""

    name: str  # what people call the family: "Mixamo"
    # joint -> bones that play it, best first, written as `plain_name` writes them
    joints: dict[str, tuple[str, ...]]

    @classmethod
    def load(cls, path: str | Path) -> BoneMap:
        """Read a bone map: JSON with ``name`` and ``joints`` (joint name to bone names).

        A ValueError names the file and its fault.
        """
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
            joints = {
                joint: tuple(plain_name(name) for name in ([names] if isinstance(names, str) else names))
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
            bone = next((position[name] for name in names if name in position), None)
            if bone is not None:
                matched[JOINT_INDEX[joint]] = bone
        return matched


Match = tuple[BoneMap | None, dict[int, int]]
"""A bone map and what it matches: joint index -> bone index."""


@lru_cache(maxsize=64)
def _positions(bones: tuple[str, ...]) -> dict[str, int]:
    """Number of the bone of each plain name; cached, as the clips of a library have few skeletons."""
    position: dict[str, int] = {}
    for names in (stripped_names(bones), map(plain_name, bones)):
        for index, name in enumerate(names):
            position.setdefault(name, index)
    return position


@lru_cache(maxsize=4096)
def plain_name(name: str) -> str:
    """A bone's name without name space, case and separators: ``mixamorig:LeftArm`` -> ``leftarm``."""
    name = re.sub(r"^.*[:|]", "", name)
    name = re.sub(r"^mixamorig\d*[_ ]?", "", name, flags=re.IGNORECASE)
    return re.sub(r"[^0-9a-z]", "", name.lower())


def stripped_names(bones: Sequence[str]) -> list[str]:
    """Plain names of all bones, without a prefix that most of them share (``Neo_Hips``)."""
    local = [re.sub(r"^.*[:|]", "", name) for name in bones]
    counts = Counter(name.partition("_")[0] + "_" for name in local if "_" in name)
    prefix, uses = max(counts.items(), key=lambda item: item[1], default=("", 0))
    shared = uses > SHARED_PREFIX * len(local)
    return [plain_name(name.removeprefix(prefix) if shared else name) for name in local]


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
    return _best((bone_map, bone_map.match(bones)) for bone_map in bundled_bone_maps())


def _best(matches: Iterable[Match]) -> Match:
    """The first map that finds most required joints, then most joints; None if none finds any."""
    return max([(None, {}), *matches], key=lambda match: (-len(missing_joints(match[1])), len(match[1])))


def missing_joints(matched: dict[int, int]) -> list[str]:
    """Required joints that a match lacks."""
    return [name for name in REQUIRED_JOINTS if JOINT_INDEX[name] not in matched]
