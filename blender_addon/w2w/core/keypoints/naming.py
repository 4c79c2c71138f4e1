# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the joint set of an array: by the joints' names, by their number, by the body they make."""

import re
import warnings
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_INDEX
from ..motion.sight import Up
from ..motion.source import UnusableMotion
from ..retargeting.bone_maps import best_match, missing_joints
from ..wording import clean, join_words
from .facts import PoseFacts
from .joint_sets import JOINT_SETS, JointSet
from .paths import BONES, REQUIRED, sides_are_exchanged

SIDE_WORDS = {"l": "left", "left": "left", "r": "right", "right": "right"}

RIG = "smpl-24"
"""The set whose joints are the bones' of a rig."""

SAME_JOINTS = ("mm-fit-17", "joint-centres")
"""Sets with joints that another one has: only taken if asked for by name."""

CANDIDATES = [name for name in JOINT_SETS if name not in SAME_JOINTS]

HOLISTIC = (543, 553)
"""Points of MediaPipe's body, hands and face, without and with the irises, as FreeMoCap saves them."""

FEATURES = {263: 22, 251: 21}
"""Numbers a frame in HumanML3D's and KIT's features (Guo et al. 2022), and the joints that they are of."""

CLEARLY = 0.6
"""A set is chosen by its body if the bones vary in length at most this much of the next best's."""

ELASTIC = 0.1
"""A rig's bones change in length by less, as part of it."""

LOWEST_STEADINESS = 1e-9

FLAT = 0.02
"""Joints whose third numbers spread at most this much of the others lie in a plane: no body does. Along its
thinnest axis, a person with both arms stretched out spreads five times as much."""

IN_PARTS = 1.5
"""Parts of a picture, counted from its corner or its middle, reach little beyond 1."""

ALIKE = 0.08
"""Limbs of people differ less between the sides, as part of their mean length; in UTD-MHAD by .075."""


class RawPose(NamedTuple):
    """Joint positions as a file has them."""

    positions: np.ndarray
    names: tuple[str, ...]  # of the joints; empty if the file has none
    facts: PoseFacts  # what the file says of them
    up: Up | None = None  # the axis that is up in all files of the program that wrote it
    firm: bool = False  # whether the usual axis is the format's own


def joint_set_of(raw: RawPose, wanted: str | None) -> tuple[JointSet, np.ndarray, bool]:
    """The joint set of a file's content, its joints in that set's order, shape (T, J, 3), and their axes.

    The last is whether these are left-handed, as in Unity: a rig names its sides rightly. `wanted` is one of
    `JOINT_SETS`, if known. Raises UnusableMotion if no set fits, or several do.
    """
    if raw.positions.dtype.kind not in "fiu":
        raise UnusableMotion("its positions are no numbers")
    if not raw.names:
        return *_by_number(raw, wanted), False
    named = _named(raw.names, wanted)
    key, numbers = named or _played(raw.names)
    joint_set, nowhere = JOINT_SETS[key], np.full((len(raw.positions), 3), np.nan)
    columns = [nowhere if number is None else raw.positions[:, number, :3] for number in numbers]
    positions = _deep(np.stack(columns, axis=1), [key])
    if not named and not _unsteadiness(joint_set, positions)[0] < ELASTIC:
        raise UnusableMotion(
            "the bones between its joints change their lengths: its columns look like angles, not positions: "
            "take the table of positions, or the BVH file itself"
        )
    return joint_set, positions, not named and sides_are_exchanged(positions, joint_set)


def _by_number(raw: RawPose, wanted: str | None) -> tuple[JointSet, np.ndarray]:
    positions = _three_axes(raw.positions, wanted)
    n_joints = positions.shape[1]
    if wanted is not None:
        joint_set = JOINT_SETS[wanted]
        if len(joint_set.joints) != n_joints:
            raise UnusableMotion(f"it holds {n_joints} joints, and {wanted} has {len(joint_set.joints)}")
        return joint_set, _deep(positions, [wanted])
    fitting = [name for name in CANDIDATES if len(JOINT_SETS[name].joints) == n_joints]
    if not fitting:
        known = ", ".join(f"{name} ({len(item.joints)})" for name, item in JOINT_SETS.items())
        raise UnusableMotion(f"it holds {n_joints} joints, and no joint set has so many; there are {known}")
    return JOINT_SETS[_by_steadiness(fitting, _deep(positions, fitting))], positions


def _three_axes(array: np.ndarray, wanted: str | None) -> np.ndarray:
    """Positions (T, J, 3) of an array that may hold them flat or with a confidence."""
    if array.ndim == 2 and array.shape[1] in FEATURES:
        array = _placed(array.astype(np.float64))
    if array.ndim == 2 and array.shape[1] % 3 == 0 and array.shape[1]:
        array = array.reshape(len(array), -1, 3)
    if array.ndim == 3 and array.shape[1] in HOLISTIC:
        array = array[:, :33]
    if array.ndim == 3 and array.shape[2] == 2:
        raise UnusableMotion(IN_THE_PICTURE.format(""))
    if array.ndim != 3 or array.shape[2] not in (3, 4):
        of = f" of {wanted}" if wanted else ""
        raise UnusableMotion(f"it has shape {array.shape}; joint positions{of} have (frames, joints, 3)")
    return array[:, :, :3]


def _placed(features: np.ndarray) -> np.ndarray:
    """Positions (T, J, 3) in HumanML3D's features.

    They begin with the root's turn about y since the frame before (half the angle), its two steps and its
    height; then follow the other joints against the root, as it is turned.
    """
    turned = np.concatenate([[0.0], np.cumsum(features[:-1, 0])])
    back = Rotation.from_rotvec(-2 * turned[:, None] * [0, 1, 0]).as_matrix()
    steps = np.zeros((len(features), 3))
    steps[1:, [0, 2]] = features[:-1, 1:3]
    root = np.cumsum(np.einsum("tij,tj->ti", back, steps), axis=0)
    others = features[:, 4 : 1 + 3 * FEATURES[features.shape[1]]].reshape(len(features), -1, 3)
    joints = np.einsum("tij,tkj->tki", back, others) + root[:, None]
    root[:, 1] = features[:, 3]
    return np.concatenate([root[:, None], joints], axis=1)


IN_THE_PICTURE = (
    "it holds positions in the picture (2D){}; a sensor's signal needs the third dimension: lift them to 3D "
    "first"
)


def _deep(positions: np.ndarray, fitting: list[str]) -> np.ndarray:
    """Positions (T, J, 3), refused where their third numbers are scores, or all the same.

    Next to pixels scores are flat. Next to parts of a picture they do not make the bones of any fitting set
    steadier, as depth does.
    """
    seen = np.where(np.isfinite(positions).all(axis=2) & (positions != 0).any(axis=2), 1.0, np.nan)
    values = np.where(np.isnan(seen)[..., None], np.nan, positions)
    with warnings.catch_warnings(action="ignore"):  # frames in which nobody is seen
        spread = np.nanmedian(np.nanstd(values, axis=1), axis=0)
        lowest, highest = (find(values, axis=(0, 1), initial=0) for find in (np.nanmin, np.nanmax))
    flat = spread[2] <= FLAT * spread[:2].max()
    if not flat and lowest[2] == 0 and highest[2] <= 1 and max(*highest, *-lowest) <= IN_PARTS:
        sets = [JOINT_SETS[name] for name in fitting]
        flat = not any(_steadier(item, positions, positions * [1, 1, 0]) for item in sets)
    if flat:
        raise UnusableMotion(IN_THE_PICTURE.format(" with a score or nothing as third number"))
    return positions


def _steadier(joint_set: JointSet, positions: np.ndarray, others: np.ndarray) -> bool:
    """Whether the bones of some positions keep their length clearly better than those of others."""
    (changes, apart), (other_changes, other_apart) = (
        _unsteadiness(joint_set, those) for those in (positions, others)
    )
    return changes <= CLEARLY * other_changes and apart <= max(ALIKE, other_apart)


def _by_steadiness(fitting: list[str], positions: np.ndarray) -> str:
    """Among sets with this number of joints, the one whose bone lengths are constant and symmetric."""
    if len(fitting) == 1:
        return fitting[0]
    unsteady = {name: sum(_unsteadiness(JOINT_SETS[name], positions), LOWEST_STEADINESS) for name in fitting}
    best, second = sorted(unsteady, key=lambda name: unsteady[name])[:2]
    if not unsteady[best] <= CLEARLY * unsteady[second]:
        raise UnusableMotion(
            f"its {positions.shape[1]} joints may be {' or '.join(fitting)}: say which (--pose-joints, or "
            "'joint_set' in a json file of its name next to it)"
        )
    return best


def _unsteadiness(joint_set: JointSet, positions: np.ndarray) -> tuple[float, float]:
    """How much limbs' bones, where seen, change in length and differ between the sides, as part of it."""
    middles, changes = np.full((2, len(BONES)), np.nan)
    for number, (start, end) in enumerate(BONES):
        ends = [positions[:, list(joint_set.members(name))].mean(axis=1) for name in (start, end)]
        with np.errstate(invalid="ignore"):
            lengths = np.linalg.norm(ends[1].astype(np.float64) - ends[0], axis=1)
        lengths = lengths[np.isfinite(lengths) & (lengths > 0)]
        if len(lengths):
            middles[number] = np.median(lengths)
            changes[number] = np.median(np.abs(lengths - middles[number])) / middles[number]
    left, right = np.split(middles, 2)
    apart = (np.abs(left - right) / (left + right))[np.isfinite(left + right)]
    if not len(apart):
        return np.inf, np.inf
    return float(np.nanmean(changes)), float(np.mean(apart))


def plain_joint(name: str) -> str:
    """A joint's name with its side first: ``LeftHip``, ``hip_l`` and ``LHip`` are all ``left hip``."""
    spaced = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[LR])(?=[A-Z][a-z])", " ", name)
    words = [word for word in re.split(r"[^0-9a-z]+", spaced.lower()) if word]
    sides = [SIDE_WORDS[word] for word in words if word in SIDE_WORDS]
    rest = "".join(word for word in words if word not in SIDE_WORDS)
    return f"{sides[0]} {rest}" if sides else rest


Named = tuple[str, list[int | None]]
"""A set of joints, and the number of each of them among some names."""


def _named(names: tuple[str, ...], wanted: str | None) -> Named | None:
    """The set with most of its joints among the names; None if they name the hips and shoulders of none."""
    place = {plain_joint(name): number for number, name in enumerate(names)}
    best, best_rank = "", (0, 0.0)
    for key in [wanted] if wanted else CANDIDATES:
        joint_set = JOINT_SETS[key]
        there = {joint for joint in joint_set.joints if plain_joint(joint) in place}
        needed = {joint for landmark in REQUIRED for joint in joint_set.landmarks[landmark]}
        rank = (len(there), len(there) / len(joint_set.joints))
        if needed <= there and rank > best_rank:
            best, best_rank = key, rank
    return (best, [place.get(plain_joint(joint)) for joint in JOINT_SETS[best].joints]) if best else None


def _played(names: tuple[str, ...]) -> Named:
    """SMPL's joints that bones of a rig play, by the bone maps; UnusableMotion if these know no such rig."""
    _, matched = best_match(names)
    if missing := missing_joints(matched):
        held = clean(", ".join(names[:8])) + (", ..." if len(names) > 8 else "")
        raise UnusableMotion(
            f"its joints' names ({held}) are of no joint set or bone map that W2W knows: it lacks "
            f"{join_words(missing, most=4)}; the sets are {', '.join(JOINT_SETS)}"
        )
    return RIG, [matched.get(JOINT_INDEX[joint]) for joint in JOINT_SETS[RIG].joints]
