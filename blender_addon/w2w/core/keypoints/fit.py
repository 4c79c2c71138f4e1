# SPDX-License-Identifier: GPL-3.0-or-later
"""A body's motion from the 3D joint positions that video pose estimators give.

No optimiser runs: trunk frames come from hips and shoulders, limb segments from their directions, twists from
the planes that elbows and knees bend in (`_limb_rotations`), each in closed form for all frames at once.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_INDEX, N_JOINTS, Body
from ..motion.motion import Motion
from ..motion.sight import LIMBS, TO_Z, Sight, Up
from ..motion.skinning import on_the_ground, relative_to_parents
from ..rotations import frame_of, turn_about, unit
from .joint_sets import SIDES, JointSet
from .limbs import cone_swing, hinge_bend, swing_and_twist
from .paths import Paths, Points, landmark_paths, middle

CUTOFF_HZ = 6.0
"""Band of the joints' paths by default: holds voluntary movement. Noisy pose wants less: 3 Hz for
UTD-MHAD's Kinect (docs/evidence/people.md)."""

UNSMOOTHED_HZ = 1e6
"""A band above that of any joints: their paths stay as they were seen."""

TRUNK_LIMIT, HEAD_CONE, OUT_OF_PLANE, FOREARM_TWIST = np.radians((100, 60, 20, 95))
"""Greatest angles here and in `_Limb`, a little beyond the active ranges of healthy adults (American Academy
of Orthopaedic Surgeons, Joint Motion, 1965), so that noise about a straight knee is not cut on one side."""

TOE_TRUST = 0.1
"""How far toes show a hip's twist, against a bent knee: the shank and foot turn too."""


class _Limb(NamedTuple):
    """How an arm or a leg hangs on the trunk and bends."""

    carrier: str  # joint that carries it
    parts: tuple[str, ...]  # its landmarks from the trunk outwards
    hinges: dict[str, np.ndarray]  # axis of the elbow or knee in the T-pose, by side
    twist: float  # greatest angles of the upper segment, the hinge and the end, radians
    bend: tuple[float, float]
    cone: float


_X, _Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
_ARM = _Limb(
    "spine3", ("shoulder", "elbow", "wrist", "hand"), {"left": -_Z, "right": _Z},
    np.radians(100), (np.radians(-10), np.radians(150)), np.radians(80),
)  # fmt: skip
_LEG = _Limb(
    "pelvis", ("hip", "knee", "ankle", "toe"), {"left": _X, "right": _X},
    np.radians(60), (np.radians(-10), np.radians(155)), np.radians(60),
)  # fmt: skip


@dataclass(frozen=True)
class KeypointFit:
    """A motion fitted to joint positions, and what was found on the way."""

    motion: Motion
    scale: float  # body metres in one unit of the positions, by the lengths of the limbs' bones
    exchanged: bool  # whether left and right were called the wrong way round throughout


def fit_keypoints(
    keypoints: np.ndarray,
    rate: float,
    joint_set: JointSet,
    body: Body,
    up: Up = "z",
    cutoff_hz: float = CUTOFF_HZ,
) -> KeypointFit:
    """Fit the 24 joints' rotations to 3D joint positions; the motion stands on z = 0, unlabelled.

    Positions (T, J, 3) are in right-handed axes and any unit, NaN where a joint was not seen. `up` is the
    axis that points up: "y" for Kinect, "-y" for axes like those of a picture. `cutoff_hz` limits the band of
    the joints' paths.

    Raises ValueError if shapes disagree, or hips or shoulders are hardly ever seen.
    """
    paths = landmark_paths(np.asarray(keypoints) @ TO_Z[up].T, joint_set, rate, cutoff_hz)
    joints = _named_joints(body)
    scale = _scale(paths, joints)
    points = {name: scale * path for name, path in paths.points.items()}
    world = np.empty((len(keypoints), N_JOINTS, 3, 3))
    _trunk_rotations(world, points, joints)
    _head_rotations(world, points, joints)
    carried = _carried_by_trunk(world, joints)
    pelvis = np.mean([middle(points, part) - middle(carried, part) for part in ("hip", "shoulder")], axis=0)
    for side in SIDES:
        for limb in (_ARM, _LEG):
            start, end = (f"{side} {part}" for part in limb.parts[:2])
            _anchor(points, start, end, pelvis + carried[start], world[:, JOINT_INDEX[limb.carrier]])
            _limb_rotations(world, points, joints, side, rate, limb)
    motion = Motion(relative_to_parents(world), pelvis, rate)
    return KeypointFit(on_the_ground(body, motion), scale, paths.exchanged)


def seen_joints(keypoints: np.ndarray, joint_set: JointSet) -> Sight:
    """How the people of joint positions (T, J, 3) stand and lie; NaN where a joint was not seen.

    Raises ValueError if hips and shoulders are never seen together.
    """
    keypoints = np.asarray(keypoints)
    limbs = {}
    for part in LIMBS:
        both = [keypoints[:, list(joint_set.members(f"{side} {part}"))].mean(axis=1) for side in SIDES]
        limbs[part] = np.stack(both, axis=1)
    return Sight.of(keypoints, limbs)


def _named_joints(body: Body) -> Points:
    """Rest positions by landmark."""
    joints = {name.replace("_", " "): body.joints[index] for name, index in JOINT_INDEX.items()}
    for side in SIDES:
        joints[f"{side} toe"] = joints[f"{side} foot"]
    joints["spine"] = joints["spine2"]
    return joints


def _scale(paths: Paths, joints: Points) -> float:
    """Body metres in one unit, by the limbs' bones; by the trunk, which bends, only if no limb is seen."""
    if not paths.lengths:
        return float(np.linalg.norm(middle(joints, "shoulder") - middle(joints, "hip")) / paths.trunk)
    ours = sum(np.linalg.norm(joints[end] - joints[start]) for start, end in paths.lengths)
    return float(ours / sum(paths.lengths.values()))


def _carried_by_trunk(world: np.ndarray, joints: Points) -> Points:
    """Positions of hips and shoulders by the trunk's rotations, relative to the pelvis; shape (T, 3) each."""
    spine = np.zeros((len(world), 3))
    for start, end in pairwise(("pelvis", "spine1", "spine2", "spine3")):
        spine = spine + world[:, JOINT_INDEX[start]] @ (joints[end] - joints[start])
    carried = {}
    for side in SIDES:
        carried[f"{side} hip"] = world[:, 0] @ (joints[f"{side} hip"] - joints["pelvis"])
        reach = joints[f"{side} shoulder"] - joints["spine3"]
        carried[f"{side} shoulder"] = spine + world[:, JOINT_INDEX["spine3"]] @ reach
    return carried


def _anchor(points: Points, start: str, end: str, root: np.ndarray, frame: np.ndarray) -> None:
    """Hang a limb on the trunk's own hip or shoulder, in place.

    So noise of the trunk's joints does not reach the hand or foot: only the joint's mean position, seen from
    the trunk, is taken from the data.
    """
    aside = np.median(_seen_from(frame, points[start] - root), axis=0)
    points[start] = root + frame @ aside
    if end in points:
        bone = points[end] - points[start]
        length = np.linalg.norm(bone, axis=1, keepdims=True)
        points[end] = points[start] + np.median(length) * bone / length


def _trunk_rotations(world: np.ndarray, points: Points, joints: Points) -> None:
    """Pelvis and chest by their own left and up; the spine's joints share out what lies between them."""
    bend = "spine" in points
    frames = []
    for places in (points, joints):
        hips, shoulders = middle(places, "hip"), middle(places, "shoulder")
        low = (places["spine"] if bend else shoulders) - hips
        high = shoulders - (places["spine"] if bend else hips)
        across = [places[f"left {part}"] - places[f"right {part}"] for part in ("hip", "shoulder")]
        frames.append([frame_of(across[0], low), frame_of(across[1], high)])
    pelvis, chest = (posed @ rest.T for posed, rest in zip(*frames, strict=True))
    turn = Rotation.from_matrix(pelvis.swapaxes(1, 2) @ chest).as_rotvec()
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    turn *= np.minimum(1, TRUNK_LIMIT / np.maximum(angle, 1e-12))
    world[:, 0] = pelvis
    for third in (1, 2, 3):
        world[:, JOINT_INDEX[f"spine{third}"]] = pelvis @ Rotation.from_rotvec(turn * (third / 3)).as_matrix()
    for side in SIDES:
        world[:, JOINT_INDEX[f"{side}_collar"]] = world[:, JOINT_INDEX["spine3"]]


def _head_rotations(world: np.ndarray, points: Points, joints: Points) -> None:
    """The neck leans with the head, seen from the neck or from between the shoulders.

    A nose shows the head's turn.
    """
    chest = world[:, JOINT_INDEX["spine3"]]
    world[:, JOINT_INDEX["neck"]] = world[:, JOINT_INDEX["head"]] = chest
    if "head" not in points:
        return
    rest, seen = (
        places["head"] - (places["neck"] if "neck" in points else middle(places, "shoulder"))
        for places in (joints, points)
    )
    lean = cone_swing(rest, _seen_from(chest, seen), HEAD_CONE)
    world[:, JOINT_INDEX["neck"]] = chest @ lean
    if "face" not in points:
        world[:, JOINT_INDEX["head"]] = chest @ lean
        return
    facing = _seen_from(chest @ lean, points["face"] - points["head"])
    yaw = np.arctan2(facing[:, 0], -facing[:, 1])
    turned = turn_about(np.broadcast_to([0.0, 0.0, 1.0], facing.shape), np.clip(yaw, -HEAD_CONE, HEAD_CONE))
    world[:, JOINT_INDEX["head"]] = chest @ lean @ turned


def _limb_rotations(
    world: np.ndarray, points: Points, joints: Points, side: str, rate: float, limb: _Limb
) -> None:
    """An arm's or a leg's segments, from the trunk outwards."""
    upper, lower, end, tip = (JOINT_INDEX[f"{side}_{part}".replace("toe", "foot")] for part in limb.parts)
    bones = [joints[f"{side} {end}"] - joints[f"{side} {start}"] for start, end in pairwise(limb.parts)]
    ends = pairwise(points.get(f"{side} {part}") for part in limb.parts)
    seen = [None if a is None or b is None else b - a for a, b in ends]
    hinge, trunk = limb.hinges[side], world[:, JOINT_INDEX[limb.carrier]]
    if seen[0] is None:
        world[:, [upper, lower, end, tip]] = trunk[:, None]
        return
    direction = _seen_from(trunk, seen[0])
    evidence = []
    if seen[1] is not None:
        below = unit(_seen_from(trunk, seen[1]))
        evidence.append((np.cross(unit(direction), below), 1.0))
        if limb is _LEG and seen[2] is not None:
            evidence.append((np.cross(unit(_seen_from(trunk, seen[2])), below), TOE_TRUST))
    world[:, upper] = trunk @ swing_and_twist(bones[0], hinge, direction, evidence, limb.twist, rate)
    world[:, lower] = world[:, upper]
    if seen[1] is not None:
        below = _seen_from(world[:, upper], seen[1])
        world[:, lower] = world[:, upper] @ hinge_bend(bones[1], hinge, below, *limb.bend, OUT_OF_PLANE)
    palm = [points.get(f"{side} {part}") for part in ("thumb side", "little finger side")]
    if limb is _ARM and palm[0] is not None and palm[1] is not None:
        # across the T-pose's hand, from little finger to thumb, is forward
        across = _seen_from(world[:, lower], unit(palm[0] - palm[1]))
        along = np.broadcast_to(bones[1], across.shape)
        world[:, lower] = world[:, lower] @ swing_and_twist(
            bones[1], np.array([0.0, -1.0, 0.0]), along, [(across, 1.0)], FOREARM_TWIST, rate
        )
    world[:, end] = world[:, lower]
    if seen[2] is not None:
        turned = cone_swing(bones[2], _seen_from(world[:, lower], seen[2]), limb.cone)
        world[:, end] = world[:, lower] @ turned
    world[:, tip] = world[:, end]


def _seen_from(frames: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """World vectors (T, 3) in frames (T, 3, 3)."""
    return np.einsum("tba,tb->ta", frames, vectors)
