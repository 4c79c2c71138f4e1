# SPDX-License-Identifier: GPL-3.0-or-later
"""A body's motion from the 3D joint positions that video pose estimators give.

No optimiser runs: trunk frames come from hips and shoulders, limb segments from their directions, twists from
the planes that elbows and knees bend in (`_limb_rotations`), each in closed form for all frames at once.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_INDEX, N_JOINTS, Body
from ..motion.motion import Motion
from ..motion.sight import LIMBS, TO_Z, Sight, Up
from ..motion.skinning import on_the_ground, relative_to_parents
from ..rotations import frame_of, rotation_vectors, smallest_rotation, turn_about, unit
from .joint_sets import SIDES, JointSet
from .paths import Paths, Points, landmark_paths, middle, smooth

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

    body: Body
    floating: Motion  # at whatever height
    scale: float  # body metres in one unit of the positions, by the lengths of the limbs' bones
    exchanged: bool  # whether left and right were called the wrong way round throughout

    @cached_property
    def motion(self) -> Motion:
        """The motion, which stands on z = 0."""
        return on_the_ground(self.body, self.floating)


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
    return KeypointFit(body, motion, scale, paths.exchanged)


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
    turn = rotation_vectors(pelvis.swapaxes(1, 2) @ chest)
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


DIRECTION_NOISE = 0.1
"""Error of a segment's direction, radians: how fast a hinge's plane becomes certain as it bends."""

TWIST_PRIOR = 0.7
"""Standard deviation of the twist if nothing shows it, radians."""

TWIST_BAND_HZ = 1.0
"""Band that a twist known to `DIRECTION_NOISE` over sin(bend) = itself is smoothed to."""

Evidence = tuple[np.ndarray, float]
"""A hinge axis (T, 3) in the parent's frame, which shows a segment's twist, and its weight against a hinge of
flesh and bone, 1. The axis's length across the segment, the sine of the bend, is how sharply it shows."""


def swing_and_twist(
    rest: np.ndarray,
    hinge: np.ndarray,
    direction: np.ndarray,
    evidence: list[Evidence],
    limit: float,
    rate: float,
) -> np.ndarray:
    """Rotation of a segment in its parent's frame, shape (T, 3, 3).

    `rest` (3,) is the segment's direction in the T-pose and `hinge` (3,) the axis of the joint at its far end
    there, about which a positive turn bends it; `direction` (T, 3) is the segment's in the parent's frame. A
    segment without evidence does not show its twist; `limit` is the greatest one, radians.
    """
    axis = unit(direction)
    swing = smallest_rotation(rest, axis)
    if not evidence:
        return swing
    reference = swing @ unit(hinge - rest * (hinge @ rest) / (rest @ rest))
    across = np.cross(axis, reference)
    noise = DIRECTION_NOISE**2
    pull, weight = np.zeros(len(axis), dtype=complex), np.zeros(len(axis))
    for shown, trust in evidence:
        cosine, sine = ((shown * basis).sum(axis=1) for basis in (reference, across))
        square = cosine**2 + sine**2
        certain = trust * np.clip(square - noise, 0, None) / noise
        pull = pull + certain * (cosine + 1j * sine) / np.sqrt(np.maximum(square, 1e-12))
        weight = weight + certain
    prior = 1 / TWIST_PRIOR**2
    total = weight + prior
    target = (pull + prior) / total
    path = smooth(np.stack([target.real, target.imag], axis=1), total, rate, TWIST_BAND_HZ, order=2)
    twist = np.clip(np.arctan2(path[:, 1], path[:, 0]), -limit, limit)
    return turn_about(axis, twist) @ swing


def hinge_bend(
    rest: np.ndarray, hinge: np.ndarray, direction: np.ndarray, least: float, most: float, aside: float
) -> np.ndarray:
    """Rotation of a hinged segment in its parent's frame, within the joint's limits, shape (T, 3, 3).

    `rest` and `hinge` (3,) are the segment's direction and the hinge axis in the T-pose, `direction` (T, 3)
    is the segment's in the parent's frame. The bend is from `least` to `most`, at most `aside` out of the
    hinge's plane, radians.
    """
    along = unit(rest)
    axis = unit(hinge - along * (hinge @ along))
    ahead = np.cross(axis, along)
    direction = unit(direction)
    bend = np.arctan2(direction @ ahead, direction @ along)
    # beyond the hinge's dead point a bend reads as a large negative one
    bend = np.clip(np.where(bend < -np.pi / 2 - 0.5, bend + 2 * np.pi, bend), least, most)
    lean = np.clip(np.arcsin(np.clip(direction @ axis, -1, 1)), -aside, aside)
    plane = np.cos(bend)[:, None] * along + np.sin(bend)[:, None] * ahead
    limited = np.cos(lean)[:, None] * plane + np.sin(lean)[:, None] * axis
    turned = turn_about(np.broadcast_to(axis, plane.shape), bend)
    return smallest_rotation(plane, limited) @ turned


def cone_swing(rest: np.ndarray, direction: np.ndarray, widest: float) -> np.ndarray:
    """Smallest rotation from the T-pose's direction, no wider than a cone; shape (T, 3, 3).

    `rest` is (3,), `direction` (T, 3) in the parent's frame, `widest` half the cone's opening, radians.
    """
    along, direction = unit(rest), unit(direction)
    axis = unit(np.cross(along, direction))
    angle = np.arccos(np.clip(direction @ along, -1, 1))
    return turn_about(axis, np.minimum(angle, widest))
