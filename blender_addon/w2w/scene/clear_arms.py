# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms held clear of the trunk while cloth is simulated: nothing can lie between parts that overlap.

A recorded pose on a body of another build sinks hanging arms some centimetres into trunk and hips.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from scipy.spatial.transform import Rotation

from ..core.body.body import Body
from ..core.body.skeleton import JOINT_INDEX
from ..core.motion.motion import Motion
from ..core.motion.skinning import skin, skinning_transforms

ANGLES = np.arange(0.0, 16.0, 3.0)
"""Angles by which an arm may be turned outward, degrees."""

ROOM = 0.016
"""Left between arm and trunk for two layers of cloth, metres."""

AS_CLEAR = 0.05
"""Share of the overlap that a smaller angle may leave beyond the least that any leaves."""

FRAMES, EVERY = 10, 3
"""Frames of a clip looked at; every so many-th vertex of an arm."""

FROM = 0.4
"""Where on the upper arm looking begins, in its lengths: nearer to the shoulder skin always meets skin."""

RAY = Vector((0.37, 0.61, 0.70)).normalized()
"""Along no axis, so that rays seldom meet an edge."""

PAST = 1e-5
"""How far beyond a face a ray goes on, metres."""

SIDES = {"left": -1.0, "right": 1.0}


def with_clear_arms(body: Body, motion: Motion) -> Motion:
    """A motion with each arm turned outward at the shoulder, throughout, as far as it takes to be clear.

    Parameters
    ----------
    body : Body
    motion : Motion
    """
    return replace(motion, rotations=_turned(motion, {side: outward(body, motion, side) for side in SIDES}))


def outward(body: Body, motion: Motion, side: str) -> float:
    """Degrees by which an arm has to be turned outward: the least of `ANGLES` that leaves next to no overlap.

    Parameters
    ----------
    body : Body
    motion : Motion
    side : str
        "left" or "right".
    """
    frames = np.unique(np.linspace(0, motion.n_frames - 1, FRAMES).round().astype(int))
    few = replace(motion, rotations=motion.rotations[frames], pelvis=motion.pelvis[frames])
    trunks = _trunks(body, few)
    arm = _arm(body, side)
    sunk = []
    for angle in ANGLES:
        turned = replace(few, rotations=_turned(few, {side: angle}))
        points = _pushed_out(body, arm, turned)
        sunk.append(sum(_inside(tree, own) for tree, own in zip(trunks, points, strict=True)))
        if not sunk[-1]:
            break
    bearable = min(sunk) + AS_CLEAR * sunk[0]
    return float(ANGLES[np.flatnonzero(np.array(sunk) <= bearable)[0]])


def _turned(motion: Motion, degrees: dict[str, float]) -> np.ndarray:
    rotations = motion.rotations.copy()
    for side, angle in degrees.items():
        turn = Rotation.from_euler("y", SIDES[side] * angle, degrees=True).as_matrix()
        joint = JOINT_INDEX[f"{side}_shoulder"]
        rotations[:, joint] = turn @ rotations[:, joint]
    return rotations


def _moved_by(body: Body, side: str) -> np.ndarray:
    """Vertices that follow the bones of an arm most."""
    joints = [JOINT_INDEX[f"{side}_{name}"] for name in ("shoulder", "elbow", "wrist", "hand")]
    return np.isin(body.weights.argmax(axis=1), joints)


def _arm(body: Body, side: str) -> np.ndarray:
    """Vertices of an arm that can be clear of the trunk, some of them."""
    shoulder, elbow = (body.joints[JOINT_INDEX[f"{side}_{name}"]] for name in ("shoulder", "elbow"))
    bone = elbow - shoulder
    along = (body.vertices - shoulder) @ bone / (bone @ bone)
    return np.flatnonzero(_moved_by(body, side) & (along > FROM))[::EVERY]


def _pushed_out(body: Body, arm: np.ndarray, motion: Motion) -> np.ndarray:
    """Vertices of an arm in each frame, off the skin by the room that cloth takes, shape (T, N, 3)."""
    thick = replace(body, vertices=body.vertices + ROOM * body.vertex_normals)
    return skin(thick, skinning_transforms(body, motion), arm)


def _trunks(body: Body, motion: Motion) -> list[BVHTree]:
    """The body without its arms in each frame, closed where they were."""
    without = ~(_moved_by(body, "left") | _moved_by(body, "right"))
    faces = body.faces[without[body.faces].all(axis=1)]
    caps, rims = _caps(faces, len(body.vertices))
    whole = [*faces.tolist(), *caps]
    posed = skin(body, skinning_transforms(body, motion))
    middles = np.stack([posed[:, rim].mean(axis=1) for rim in rims], axis=1) if rims else posed[:, :0]
    return [
        BVHTree.FromPolygons(points.tolist(), whole) for points in np.concatenate([posed, middles], axis=1)
    ]


def _caps(faces: np.ndarray, n_vertices: int) -> tuple[list[tuple[int, int, int]], list[list[int]]]:
    """Triangles from each rim of a surface to a further vertex in its middle, and the rims."""
    sides = {(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}
    onward = {b: a for a, b in sides if (b, a) not in sides}
    caps, rims = [], []
    while onward:
        rim = []
        vertex = next(iter(onward))
        while vertex in onward:
            rim.append(vertex)
            vertex = onward.pop(vertex)
        middle = n_vertices + len(rims)
        caps += [(rim[number - 1], rim[number], middle) for number in range(len(rim))]
        rims.append(rim)
    return caps, rims


def _inside(tree: BVHTree, points: np.ndarray) -> int:
    """How many points a closed surface has inside."""
    return sum(times_inside(tree, Vector(point)) > 0 for point in points.tolist())


def times_inside(tree: BVHTree, point: Vector) -> int:
    """How many times more a ray from a point leaves a closed surface than it enters it.

    Once where the point is inside, twice where two parts of the surface overlap there.
    """
    turns = 0
    while True:
        place, normal, _, _ = tree.ray_cast(point, RAY)
        if place is None:
            return turns
        turns += 1 if normal.dot(RAY) > 0 else -1
        point = place + PAST * RAY
