# SPDX-License-Identifier: GPL-3.0-or-later
"""Acclaim's skeleton (.asf) and motion (.amc) files, as CMU and HDM05 publish their motion capture."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, permutations
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..motion.source import (
    TO_Z_UP,
    SourceMotion,
    UnusableMotion,
    reading,
    refuse_few_frames,
    refuse_too_long,
    size_and_head,
    usable_rate,
)
from ..wording import clean, restated

AMC_SUFFIX, ASF_SUFFIX = ".amc", ".asf"

USUAL_RATE = 120.0
"""Frames per second of CMU's and HDM05's files; the format lacks them."""

MAX_ASF_BYTES = 1 << 22

ROOT = "root"
TURNS, SHIFTS = ("rx", "ry", "rz"), ("tx", "ty", "tz")
ORDERS = {"".join(axes) for axes in permutations("xyz")}


@dataclass
class _Bone:
    """A segment: its direction and length, its axes, and its degrees of freedom."""

    name: str
    direction: np.ndarray
    length: float
    axis: np.ndarray  # degrees
    order: str
    moves: tuple[str, ...]
    parent: int = -1


def skeleton_file(path: Path) -> Path:
    """The .asf of an .amc: of the same name, of the longest beginning of it, or the only one.

    Raises UnusableMotion if none lies next to it, or several that it could be.
    """
    skeletons = sorted(file for file in path.parent.iterdir() if file.suffix.lower() == ASF_SUFFIX)
    stem = path.stem.lower()
    starting = [file for file in skeletons if stem.startswith(file.stem.lower())]
    if starting:
        return max(starting, key=lambda file: len(file.stem))
    if len(skeletons) == 1:
        return skeletons[0]
    names = ", ".join(clean(file.name) for file in skeletons[:5])
    what = f"several lie there ({names})" if skeletons else "none lies there"
    raise UnusableMotion(f"an .amc needs the .asf of its skeleton in the same folder, and {what}")


def read_amc(path: Path, rate: float | None = None) -> SourceMotion:
    """Read a motion and the skeleton next to it: z up, in the file's own unit of length.

    `rate` is in frames per second; CMU's and HDM05's 120 by default. Raises UnusableMotion, with the reason.
    """
    rate = usable_rate(USUAL_RATE, rate)
    size_and_head(path)
    with reading():
        skeleton = skeleton_file(path)
        if size_and_head(skeleton)[0] > MAX_ASF_BYTES:
            raise UnusableMotion(f"its skeleton {clean(skeleton.name)} is too large to be one")
        damaged = f"its skeleton {clean(skeleton.name)} is damaged:"
        with restated(damaged, (ValueError, IndexError, KeyError), UnusableMotion):
            bones = _skeleton(_lines(skeleton))
        values, position = _frames(_lines(path), bones)
    return _source(bones, values, position, rate)


def _lines(path: Path) -> list[str]:
    text = path.read_text(encoding="latin-1")
    return [line for line in (raw.partition("#")[0].strip() for raw in text.splitlines()) if line]


def _skeleton(lines: list[str]) -> list[_Bone]:
    """Bones, the root first, parents before children."""
    parts: dict[str, list[str]] = {}
    held: list[str] = []
    for line in lines:
        if line.startswith(":"):
            name, _, rest = " ".join(line[1:].split()).partition(" ")
            held = parts[name.lower()] = [rest] if rest else []
        else:
            held.append(line)
    missing = [name for name in ("root", "bonedata", "hierarchy") if name not in parts]
    if missing:
        raise ValueError(f"it lacks :{', :'.join(missing)}")
    if any(line.lower().split() == ["angle", "rad"] for line in parts.get("units", ())):
        raise ValueError("its angles are in radians; only degrees are known")
    bones = {bone.name: bone for bone in (_root(parts["root"]), *_bones(parts["bonedata"]))}
    ordered, place = [bones[ROOT]], {ROOT: 0}
    waiting = [line.split() for line in parts["hierarchy"] if line.lower() not in ("begin", "end")]
    while waiting:
        ready = [words for words in waiting if words[0] in place]
        if not ready:
            raise ValueError(f"its hierarchy does not lead from the root to {waiting[0][0]}")
        for parent, *children in ready:
            for child in children:
                if child in place:
                    raise ValueError(f"its bone {child} has two parents")
                bones[child].parent = place[parent]
                place[child] = len(ordered)
                ordered.append(bones[child])
        waiting = [words for words in waiting if words not in ready]
    return ordered


def _root(lines: list[str]) -> _Bone:
    facts = {line.split()[0].lower(): line.split()[1:] for line in lines}
    axis = [*facts.get("orientation", ["0", "0", "0"]), facts.get("axis", ["XYZ"])[0]]
    return _bone({"name": [ROOT], "axis": axis, "dof": facts["order"]})


def _bones(lines: list[str]) -> Iterator[_Bone]:
    facts: dict[str, list[str]] | None = None
    for line in lines:
        key, *words = line.split()
        if key.lower() == "begin":
            facts = {}
        elif facts is not None and key.lower() == "end":
            yield _bone(facts)
            facts = None
        elif facts is not None:
            facts[key.lower()] = words


def _bone(facts: dict[str, list[str]]) -> _Bone:
    """The bone of the words of its lines, by each line's first word."""
    axis = facts.get("axis", ["0", "0", "0", "XYZ"])
    order = axis[3].lower()
    if order not in ORDERS:
        raise ValueError(f"{order} is no order of axes")
    return _Bone(
        facts.get("name", [""])[0],
        np.array([float(word) for word in facts.get("direction", ["0", "1", "0"])[:3]]),
        float(facts.get("length", ["0"])[0]),
        np.array([float(word) for word in axis[:3]]),
        order,
        tuple(word.lower() for word in facts.get("dof", ())),
    )


def _frames(lines: list[str], bones: list[_Bone]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Values of each bone by frame, and the root's position."""
    starts = [number for number, line in enumerate(lines) if line.isdigit()]
    refuse_few_frames(len(starts))
    if any(line.upper().startswith(":RADIANS") for line in lines[: starts[0]]):
        raise UnusableMotion("its angles are in radians; only degrees are known")
    refuse_too_long(len(starts), len(bones))
    moving = {bone.name: bone.moves for bone in bones if bone.moves}
    values = {name: np.zeros((len(starts), len(moves))) for name, moves in moving.items()}
    for frame, (start, stop) in enumerate(pairwise([*starts, len(lines)])):
        for line in lines[start + 1 : stop]:
            name, *words = line.split()
            if name not in moving:
                raise UnusableMotion(f"its frame {frame + 1} moves {name[:40]}, which its skeleton does not")
            try:
                values[name][frame] = [float(word) for word in words]
            except ValueError as error:
                raise UnusableMotion(
                    f"its frame {frame + 1} gives {name[:40]} other than {len(moving[name])} numbers"
                ) from error
    if not all(np.isfinite(found).all() for found in values.values()):
        raise UnusableMotion("its animation holds values that are not finite")
    shifts = [moving[ROOT].index(axis) for axis in SHIFTS if axis in moving[ROOT]]
    if len(shifts) < 3:
        raise UnusableMotion("its root does not move along all three axes")
    return values, values[ROOT][:, shifts]


def _source(bones: list[_Bone], values: dict[str, np.ndarray], root: np.ndarray, rate: float) -> SourceMotion:
    rest = np.tile(np.eye(4), (len(bones), 1, 1))
    moved = np.tile(np.eye(4), (len(root), len(bones), 1, 1))
    moved[:, 0, :3, 3] = root
    reaches = [bone.direction / max(np.linalg.norm(bone.direction), 1e-12) * bone.length for bone in bones]
    for number, bone in enumerate(bones):
        turn, parent = _turn(bone, values.get(bone.name)), bone.parent
        if parent >= 0:
            turned, reach = moved[:, parent, :3, :3], reaches[parent]
            turn = turned @ turn
            rest[number, :3, 3] = rest[parent, :3, 3] + reach
            moved[:, number, :3, 3] = moved[:, parent, :3, 3] + turned @ reach
        moved[:, number, :3, :3] = turn
    parents = np.array([bone.parent for bone in bones])
    names = tuple(bone.name for bone in bones)
    return SourceMotion(names, parents, TO_Z_UP @ rest @ TO_Z_UP.T, TO_Z_UP @ moved @ TO_Z_UP.T, rate)


def _turn(bone: _Bone, values: np.ndarray | None) -> np.ndarray:
    """Turn of a bone against its parent in each frame, in the axes of the rest pose, (T, 3, 3) or (3, 3).

    The bone turns about its own axes, which stand turned by `axis` in the rest pose: C M C^-1. The first
    axis of an order is applied first.
    """
    places = [place for place, move in enumerate(bone.moves) if move in TURNS]
    if values is None or not places:
        return np.eye(3)
    own = Rotation.from_euler(bone.order, bone.axis, degrees=True).as_matrix()
    order = "".join(bone.moves[place][1] for place in places)
    turned = Rotation.from_euler(order, values[:, places], degrees=True)
    return own @ turned.as_matrix().reshape(-1, 3, 3) @ own.T
