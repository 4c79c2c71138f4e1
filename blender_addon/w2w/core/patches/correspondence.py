# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the point of our body for each point of a user's own character, which then shows maps and sensors.

The character is laid on our body: each part of it is turned, and scaled along and across its bone, so that
the joints of both are at the same places. Then each of its vertices belongs to the point of our surface
that is nearest, of the same part of the body and facing the same way.

`likeness` gives our body the character's proportions first, as far as its shape goes.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from ..adopt.registration import closest_on, shares_on
from ..adopt.rest_pose import metres_per_unit
from ..body.body import (
    JOINT_INDEX,
    JOINT_NAMES,
    LEG,
    N_JOINTS,
    PARENTS,
    Body,
    limb_length,
    trunk_line,
    vertex_normals,
)
from ..body.shapes import RANGES, shaped
from ..retargeting.retarget import SEGMENT_END, rest_alignment
from ..rotations import unit

SAME_PART = 0.06
"""Metres that being of two parts of the body is worth: the hand that hangs at a thigh is no thigh."""

SAME_SIDE = 0.02
"""Metres that facing two ways is worth: a palm is no back of a hand."""

GIRTHS = (0.5, 2.0)
"""How many times thicker or thinner than by its length a part may be to be fitted by its thickness."""

TRUNK = ("pelvis", "spine1", "spine2", "spine3", "neck", "head")
COLLARS = (("left_collar", "left_shoulder"), ("right_collar", "right_shoulder"))

ONWARD = {JOINT_INDEX[start]: JOINT_INDEX[end] for start, end in (*pairwise(TRUNK), *COLLARS)} | {
    start: end for start, end in SEGMENT_END.items() if not JOINT_NAMES[start].endswith("wrist")
}
"""Joints with a bone to the next; the others end in a hand, a foot or the head."""

CARRIED_BY = {
    joint: PARENTS[joint] for joint, name in enumerate(JOINT_NAMES) if name.endswith(("hand", "foot"))
}
"""Joints whose part is one with their parent's, for many rigs lack them."""


def _part(joint: int) -> int:
    name = JOINT_NAMES[joint]
    if name.startswith("spine") or name.endswith("collar"):
        return JOINT_INDEX["pelvis"]
    return CARRIED_BY.get(joint, joint)


PARTS = np.array([_part(joint) for joint in range(N_JOINTS)])
"""Part of the body that each joint moves, named by its first joint: the trunk is one."""


@dataclass(frozen=True, eq=False)
class Character:
    """Somebody's own character in its rest pose, in any axes and unit."""

    vertices: np.ndarray  # (V, 3), of all its meshes
    faces: np.ndarray  # (F, 3), triangles
    # (V, 24), by the joints that its bones play; a row of zeros if no bone moves a vertex
    weights: np.ndarray
    # position (3,) of each joint that has a bone; the required ones are there
    joints: Mapping[int, np.ndarray]


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points of a body's surface."""

    faces: np.ndarray  # (V,), the triangle that each lies on
    shares: np.ndarray  # (V, 3), barycentric coordinates
    distance: np.ndarray  # (V,), from the character's vertex, once that is laid on the body, metres


def correspond(character: Character, body: Body) -> SurfacePoints:
    """The point of a body's surface that each vertex of a character is."""
    weights = _whole_weights(character)
    laid = lay_on(character, body, weights)
    _, nearest = cKDTree(_features(body.vertices, body.vertex_normals, body.weights)).query(
        _features(laid, vertex_normals(laid, character.faces), weights)
    )
    faces = _faces_around(body)[nearest]
    triangles = body.vertices[body.faces[faces]]
    closest, distance = closest_on(triangles, laid)
    rows, best = np.arange(len(laid)), distance.argmin(axis=1)
    shares = shares_on(triangles[rows, best], closest[rows, best])
    return SurfacePoints(faces[rows, best], shares, distance[rows, best])


def lay_on(character: Character, body: Body, weights: np.ndarray) -> np.ndarray:
    """The character's vertices (V, 3) where our body stands, its joints on ours.

    `weights` (V, 24) are the character's, every row summing to 1.
    """
    turns = rest_alignment(body, dict(character.joints)).swapaxes(-1, -2)
    scale = limb_length(body.joints) / limb_length(character.joints)
    joints = np.empty((N_JOINTS, 3))
    for joint, parent in enumerate(PARENTS):
        onward = turns[parent].T @ (body.joints[joint] - body.joints[parent]) / scale
        joints[joint] = character.joints.get(joint, joints[parent] + onward)  # without a bone as ours
    laid = np.zeros((len(character.vertices), 3))
    for joint in range(N_JOINTS):
        part = CARRIED_BY.get(joint, joint)
        turned = (character.vertices - joints[part]) @ turns[part].T
        along, across = _stretch(part, turned, weights, joints, body, scale)
        axis = _axis(part, body.joints)
        moved = across * turned + (along - across) * np.outer(turned @ axis, axis)
        laid += weights[:, joint, None] * (moved + body.joints[part])
    return laid


def _stretch(
    part: int, turned: np.ndarray, weights: np.ndarray, joints: np.ndarray, body: Body, scale: float
) -> tuple[float, float]:
    """How much longer, and how much thicker, our body is in one part."""
    end, axis = ONWARD.get(part), _axis(part, body.joints)
    girths = []
    for points, share in ((body.vertices - body.joints[part], body.weights), (turned, weights)):
        members = points[PARTS[share.argmax(axis=1)] == PARTS[part]]
        aside = members - np.outer(members @ axis, axis)
        girths.append(float(np.median(np.linalg.norm(aside, axis=1))) if len(members) else 0.0)
    across = scale * float(np.clip(girths[0] / girths[1] / scale, *GIRTHS)) if min(girths) > 0 else scale
    if end is None:
        return across, across
    length = float(np.linalg.norm(joints[end] - joints[part]))
    along = float(np.linalg.norm(body.joints[end] - body.joints[part])) / length if length > 0 else scale
    return scale * float(np.clip(along / scale, *GIRTHS)), across


def _axis(part: int, joints: np.ndarray) -> np.ndarray:
    """Unit direction of our body's bone that begins at a joint; zero if no bone does."""
    if part not in ONWARD:
        return np.zeros(3)
    return unit(joints[ONWARD[part]] - joints[part])


def _whole_weights(character: Character) -> np.ndarray:
    """Weights whose rows sum to 1; a vertex that no bone moves is with the nearest that one does."""
    sums = character.weights.sum(axis=1)
    moved = np.flatnonzero(sums > 0)
    if len(moved) == 0:
        raise ValueError("no bone that plays a joint of the body moves its meshes")
    weights = character.weights / np.where(sums > 0, sums, 1)[:, None]
    still = np.flatnonzero(sums <= 0)
    if len(still):
        _, nearest = cKDTree(character.vertices[moved]).query(character.vertices[still])
        weights[still] = weights[moved[nearest]]
    return weights


def _features(vertices: np.ndarray, normals: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Coordinates (V, 3 + parts + 3) in which points of two bodies are compared."""
    parts = np.stack([weights[:, part == PARTS].sum(axis=1) for part in np.unique(PARTS)], axis=1)
    return np.concatenate([vertices, SAME_PART * parts, SAME_SIDE * normals], axis=1)


def _faces_around(body: Body) -> np.ndarray:
    """Faces that meet at each vertex, shape (V, most); the first again if there are fewer."""
    corners = body.faces.ravel()
    order = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(body.vertices))
    starts = np.cumsum(counts) - counts
    columns = np.minimum(np.arange(counts.max()), np.maximum(counts, 1)[:, None] - 1)
    return order[np.minimum(starts[:, None] + columns, len(order) - 1)] // 3


LIMBS = {"arms": ("shoulder", "elbow", "wrist"), "legs": LEG}


def likeness(character: Character, body: Body) -> dict[str, float]:
    """Parameters of `shapes.shaped` that give our body, the bundled one, a character's proportions.

    Length of arms and legs by that of the trunk, within the range of shapes; and the height, if it is that
    of a person and can be reached.
    """
    joints, trunk = character.joints, trunk_line(character.joints)
    shape = {}
    for name, parts in LIMBS.items():
        ratio = limb_length(joints, parts) / np.linalg.norm(trunk)
        own = limb_length(body.joints, parts) / np.linalg.norm(trunk_line(body.joints))
        shape[name] = float(np.clip(ratio / own, *RANGES[name]))
    height = float(np.ptp(character.vertices @ trunk) / np.linalg.norm(trunk))
    with suppress(ValueError):  # it is nobody's height, or none that goes with these limbs
        metres = height * metres_per_unit(height)
        if RANGES["height"][0] <= metres <= RANGES["height"][1]:
            shaped(body, height=metres, **shape)
            shape["height"] = metres
    return shape
