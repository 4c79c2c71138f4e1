# SPDX-License-Identifier: GPL-3.0-or-later
"""Retarget any named skeleton's motion to the 24 joints, through world-space rotations.

Each joint takes over its bone's world rotation relative to the rest pose, so bone roll and
local axes never matter. What the two rest poses differ by is made up for once: the torso by
its own frame (left, up), each limb segment by the smallest rotation that lays the body's
segment on the source's, carried down the chain. A T-pose, an A-pose and arms hanging down
thus all give the same motion.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..body.body import (
    JOINT_INDEX,
    JOINT_NAMES,
    LEG,
    N_JOINTS,
    PARENTS,
    Body,
    Joints,
    limb_length,
    midpoint,
    trunk_line,
)
from ..motion.believable import times_too_far
from ..motion.motion import Motion
from ..motion.skinning import joint_transforms, on_the_ground, relative_to_parents
from ..motion.source import SourceMotion, UnusableMotion, unscaled_rotations
from ..rotations import frame_of, smallest_rotation, unit
from .bone_maps import BoneMap, best_match, missing_joints
from .structure_match import match_by_structure, with_whole_spine

SIDES = ("left", "right")

ACROSS = tuple(tuple(JOINT_INDEX[f"{side}_{part}"] for side in SIDES) for part in ("hip", "shoulder"))
"""Left and right hip, left and right shoulder."""

CRUMPLED = 1e-3
"""Left and right joints of a rest pose closer than this part of its extent show no side."""

SEGMENT_END = {
    JOINT_INDEX[f"{side}_{start}"]: JOINT_INDEX[f"{side}_{end}"]
    for side in ("left", "right")
    for chain in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist", "hand"))
    for start, end in pairwise(chain)
}
"""Joints whose segment is laid along the source's: the joint at its far end."""

BY_STRUCTURE = "unknown (matched by its structure)"
"""Name of a skeleton whose bones' names say nothing."""

ABSURD_BOB = 5.0
"""Hips that rise and fall by more leg lengths than this are in another unit than the legs: some takes travel
in centimetres on a rig in metres."""

USUAL = (10, 90)
"""Percentiles of heights between which damaged frames do not count."""

CENTIMETRES = 100.0

UPRIGHT = np.cos(np.radians(20))
"""A rest pose whose trunk leans less than this off an axis of the world has that axis up."""

STRAIGHT_LEG = np.cos(np.radians(25))
"""A shank that leans less than this in the rest pose carries a foot that stands flat."""


@dataclass(frozen=True)
class Retargeting:
    """A motion retargeted to a body, and how."""

    motion: Motion
    bone_map: str  # name of the bone map that matched, or `BY_STRUCTURE`
    bones: dict[str, str]  # joint -> source bone, for the joints that have one
    scale: float  # body metres in one unit of the source, by the length of the legs
    rest: np.ndarray  # (24, 3, 3), world rotation of each joint in the source's rest pose
    path: np.ndarray  # (T, 3) of the source's own pelvis, body metres


def retarget(source: SourceMotion, body: Body, maps: Iterable[BoneMap] = ()) -> Retargeting:
    """Retarget a source motion to a body; it keeps the source's world heading, and the body touches z = 0.

    The user's own bone maps are tried before the bundled ones. Raises UnusableMotion, naming the joints that
    have no bone, if the skeleton cannot be matched.
    """
    skeleton, matched = matched_joints(source, maps)
    refuse_four_legs(source, matched)
    rest = {joint: source.rest[bone, :3, 3] for joint, bone in matched.items()}
    if is_crumpled(rest):
        raise UnusableMotion("its rest pose is no body's: its hips or its shoulders lie on each other")
    alignment = rest_alignment(body, rest)
    rotations = _world_rotations(source, matched, alignment)
    length = _moving_leg_length(source, matched)
    if not length > 0:
        raise UnusableMotion(
            "its legs have no length in its frames: its joints lie on each other, or its values are so large "
            "that nothing between them is left"
        )
    scale = limb_length(body.joints) / length
    pelvis = _pelvis_path(source, matched, body, rotations[:, 0], scale)
    motion = Motion(relative_to_parents(rotations), pelvis, source.rate)
    path = source.matrices[:, matched[0], :3, 3] * scale
    if _in_centimetres(body, motion):
        pelvis = _pelvis_path(source, matched, body, rotations[:, 0], scale / CENTIMETRES)
        motion, path = replace(motion, pelvis=pelvis), path / CENTIMETRES
    bones = {JOINT_NAMES[joint]: source.bones[bone] for joint, bone in sorted(matched.items())}
    return Retargeting(on_the_ground(body, motion), skeleton, bones, scale, alignment, path)


def matched_joints(source: SourceMotion, maps: Iterable[BoneMap] = ()) -> tuple[str, dict[int, int]]:
    """Bone of each joint, by name, else by the structure of the skeleton; every required joint has one.

    Returns the name of the bone map that matched, or `BY_STRUCTURE`, and joint index -> bone index. The
    user's own bone maps are tried before the bundled ones.

    Raises UnusableMotion, naming the joints that have no bone, if neither finds all required ones.
    """
    maps = tuple(maps)
    bone_map, matched = best_match(source.bones, maps)
    missing = missing_joints(matched)
    if bone_map is not None and not missing:
        return bone_map.name, matched if bone_map in maps else with_whole_spine(source, matched)
    matched = match_by_structure(source)
    if missing_joints(matched):
        names, bones = ", ".join(missing).replace("_", " "), source.bones[source.first_bone :]
        raise UnusableMotion(
            f"no bone was found, by name or by structure, for {len(missing)} needed joints ({names}) "
            f"among its {len(bones)} bones ({', '.join(bones[:8])}, ...): give a bone map for this rig"
        )
    return BY_STRUCTURE, matched


def is_crumpled(rest: dict[int, np.ndarray]) -> bool:
    """Whether the two hips or the two shoulders of a rest pose lie on each other.

    `rest` has the position (3,) of each matched joint; pairs that are not both matched are ignored.
    """
    extent = np.ptp(list(rest.values()), axis=0).max() if rest else 0.0
    pairs = [pair for pair in ACROSS if rest.keys() >= set(pair)]
    return any(np.linalg.norm(rest[left] - rest[right]) <= CRUMPLED * extent for left, right in pairs)


def rest_alignment(body: Body, rest: dict[int, np.ndarray]) -> np.ndarray:
    """Rotation of each joint, shape (24, 3, 3), that puts the body in the source's rest pose.

    `rest` has the world position (3,) of each matched joint there.
    """
    torso = _torso_frame(body, rest)
    alignment = np.tile(torso, (N_JOINTS, 1, 1))
    for joint in range(1, N_JOINTS):
        if JOINT_NAMES[joint].endswith("ankle"):
            alignment[joint] = _foot_alignment(joint, alignment, torso, body, rest)
            continue
        on_torso = ("hip", "collar", "spine1", "spine2", "spine3", "neck", "head")
        start = torso if JOINT_NAMES[joint].endswith(on_torso) else alignment[PARENTS[joint]]
        alignment[joint] = _laid_along(joint, SEGMENT_END.get(joint), start, body, rest)
    return alignment


def _torso_frame(body: Body, rest: dict[int, np.ndarray]) -> np.ndarray:
    """Rotation from the body's rest axes (left +x, up +z) to those of the source's torso."""
    left = np.sum([unit(rest[on_left] - rest[on_right]) for on_left, on_right in ACROSS], axis=0)
    trunk = unit(trunk_line(rest))
    nearest = np.abs(trunk).argmax()
    if abs(trunk[nearest]) >= UPRIGHT:  # not only z: bind poses may have another axis up
        return frame_of(left, np.sign(trunk[nearest]) * np.eye(3)[nearest])
    own = unit(trunk_line({joint: body.joints[joint] for joint in rest}))
    return frame_of(left, trunk) @ frame_of(np.array([1.0, 0.0, 0.0]), own).T


def _laid_along(
    joint: int, end: int | None, start: np.ndarray, body: Body, rest: dict[int, np.ndarray]
) -> np.ndarray:
    if end is None or joint not in rest or end not in rest:
        return start
    target = rest[end] - rest[joint]
    if np.linalg.norm(target) == 0:
        return start
    return smallest_rotation(start @ (body.joints[end] - body.joints[joint]), target) @ start


def _foot_alignment(
    joint: int, alignment: np.ndarray, torso: np.ndarray, body: Body, rest: dict[int, np.ndarray]
) -> np.ndarray:
    """A foot stands flat in most rest poses, whatever its joint heights: turn it out, not up.

    Only where the shank itself leans is the foot's pitch taken from its joints.
    """
    knee, toe = PARENTS[joint], joint + JOINT_INDEX["left_foot"] - JOINT_INDEX["left_ankle"]
    if toe not in rest or joint not in rest:
        return torso
    shank = rest[knee] - rest[joint]
    up = torso[:, 2]
    if shank @ up < STRAIGHT_LEG * np.linalg.norm(shank):
        return _laid_along(joint, toe, alignment[knee], body, rest)
    own = torso @ (body.joints[toe] - body.joints[joint])
    target = rest[toe] - rest[joint]
    own, target = own - up * (own @ up), target - up * (target @ up)
    if np.linalg.norm(target) < 1e-6 * np.linalg.norm(shank):
        return torso
    return smallest_rotation(own, target) @ torso


def _world_rotations(source: SourceMotion, matched: dict[int, int], alignment: np.ndarray) -> np.ndarray:
    """World rotation of each joint in each frame, shape (T, 24, 3, 3)."""
    joints = sorted(matched)
    bones = [matched[joint] for joint in joints]
    turned = unscaled_rotations(source.matrices[:, bones])
    resting = unscaled_rotations(source.rest[bones])
    rotations = np.empty((source.n_frames, N_JOINTS, 3, 3))
    rotations[:, joints] = turned @ (resting.swapaxes(-1, -2) @ alignment[joints])
    for joint in range(1, N_JOINTS):
        if joint not in matched:
            carried = alignment[PARENTS[joint]].T @ alignment[joint]
            rotations[:, joint] = rotations[:, PARENTS[joint]] @ carried
    return rotations


def _pelvis_path(
    source: SourceMotion, matched: dict[int, int], body: Body, turned: np.ndarray, scale: float
) -> np.ndarray:
    """Path of the pelvis that puts the point between the hips where the source has it."""
    hips = [matched[JOINT_INDEX["left_hip"]], matched[JOINT_INDEX["right_hip"]]]
    path = source.matrices[:, hips][..., :3, 3].mean(axis=1) * scale
    offset = body.joints[0] - midpoint(body.joints, "hip")
    return path + turned @ offset


def _in_centimetres(body: Body, motion: Motion) -> bool:
    """Whether a motion travels in centimetres on a rig in metres, by its heights and its legs."""
    if np.ptp(np.percentile(motion.pelvis[:, 2], USUAL)) <= ABSURD_BOB * limb_length(body.joints):
        return False
    heads = joint_transforms(body, motion)[1]
    factor = times_too_far(heads, heads[:, 0])[0]
    return not 0 < factor < CENTIMETRES / 3


def _moving_leg_length(source: SourceMotion, matched: dict[int, int]) -> float:
    """Leg length as the frames have it: some files hold a rest pose in another unit."""
    legs = [matched[JOINT_INDEX[f"{side}_{part}"]] for side in ("left", "right") for part in LEG]
    heads = source.matrices[:, legs][..., :3, 3].reshape(source.n_frames, 2, len(LEG), 3)
    lengths = np.linalg.norm(np.diff(heads, axis=2), axis=-1).sum(axis=-1)
    return float(np.median(lengths.mean(axis=1)))


ARM = ("shoulder", "elbow", "wrist")

SQUARE = np.sin(np.radians(40))
"""Largest cosine between the trunk and limbs that carry it."""

PARALLEL = np.cos(np.radians(45))
"""Least cosine between forelegs and hind legs that carry the trunk."""

MOSTLY = 0.75
"""Part of the frames: no clip of a person at hand is on all fours, off the knees, in half of them."""

LONG_ARMS = 0.8
"""Length of arms to legs: people's are .5 to .72, some cartoons' .8."""

SAMPLES = 100
"""Frames looked at."""


def refuse_four_legs(source: SourceMotion, matched: dict[int, int]) -> None:
    """Refuse an animal: two of its rest pose, its movement and the length of its forelegs show it.

    People crawl on their knees, and a person who walks on hands and feet has shorter arms and rests upright.
    """
    frames = np.linspace(0, source.n_frames - 1, min(SAMPLES, source.n_frames)).astype(int)
    heads = source.matrices[frames, :, :3, 3].swapaxes(0, 1)
    moving = {joint: heads[bone] for joint, bone in matched.items()}
    resting = {joint: source.rest[bone, :3, 3] for joint, bone in matched.items()}
    rests = source.rest_is_known and bool(_on_all_fours(resting))
    is_long = limb_length(moving, ARM) > LONG_ARMS * limb_length(moving)
    signs = {
        "it rests on all fours": rests,
        "it moves on all fours, off its knees": (rests or is_long) and _on_all_fours(moving).mean() >= MOSTLY,
        "its arms are as long as its legs": is_long,
    }
    if sum(signs.values()) >= 2:
        why = " and ".join(sign for sign, is_there in signs.items() if is_there)
        raise UnusableMotion(f"its skeleton is that of an animal with four legs, not a person's: {why}")


def _on_all_fours(joints: Joints) -> np.ndarray:
    """Whether legs and arms stand off the trunk squarely and to one side, in each pose."""
    trunk = unit(trunk_line(joints))
    legs, arms = (_direction(joints, *ends) for ends in (("hip", "ankle"), ("shoulder", "wrist")))
    across = [abs(np.sum(trunk * limbs, axis=-1)) < SQUARE for limbs in (legs, arms)]
    found: np.ndarray = across[0] & across[1] & (np.sum(legs * arms, axis=-1) > PARALLEL)
    return found


def _direction(joints: Joints, start: str, end: str) -> np.ndarray:
    """Mean direction of both limbs."""
    ways = [
        joints[JOINT_INDEX[f"{side}_{end}"]] - joints[JOINT_INDEX[f"{side}_{start}"]]
        for side in ("left", "right")
    ]
    return unit(unit(ways[0]) + unit(ways[1]))
