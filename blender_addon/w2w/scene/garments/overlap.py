# SPDX-License-Identifier: GPL-3.0-or-later
"""How far limbs are sunk into the body: between parts that overlap no cloth can lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.body.body import Body
from ...core.body.skeleton import JOINT_INDEX
from ...core.motion.motion import Motion
from ...core.motion.skinning import skin, skinning_transforms

ARM, LEG = ("shoulder", "elbow", "wrist", "hand"), ("hip", "knee", "ankle", "foot")
"""Joints of a limb, from the trunk on."""

ROOM = 0.016
"""Left between two parts for two layers of cloth, metres."""

EVERY = 3
"""Every so many-th vertex of a limb is looked at."""

FROM = 0.4
"""Where on a limb's first bone looking begins, in its lengths: nearer to the trunk skin always meets skin."""

RAY = Vector((0.37, 0.61, 0.70)).normalized()
"""Along no axis, so that rays seldom meet an edge."""

PAST = 1e-5
"""How far beyond a face a ray goes on, metres."""


def moved_by(body: Body, side: str, joints: tuple[str, ...]) -> np.ndarray:
    """Vertices that follow the bones of a limb most, as a mask (V,)."""
    return np.isin(body.weights.argmax(axis=1), [JOINT_INDEX[f"{side}_{name}"] for name in joints])


def trunk(body: Body) -> np.ndarray:
    """Vertices of the body without its arms, as a mask (V,)."""
    return ~(moved_by(body, "left", ARM) | moved_by(body, "right", ARM))


def limb(body: Body, side: str, joints: tuple[str, ...]) -> np.ndarray:
    """Vertices of a limb that can be clear of the body, some of them."""
    root, bend = (body.joints[JOINT_INDEX[f"{side}_{name}"]] for name in joints[:2])
    bone = bend - root
    along = (body.vertices - root) @ bone / (bone @ bone)
    return np.flatnonzero(moved_by(body, side, joints) & (along > FROM))[::EVERY]


def pushed_out(body: Body, vertices: np.ndarray, motion: Motion) -> np.ndarray:
    """Vertices in each frame, off the skin by the room that cloth takes, shape (T, N, 3)."""
    thick = replace(body, vertices=body.vertices + ROOM * body.vertex_normals)
    return skin(thick, skinning_transforms(body, motion), vertices)


def closed(body: Body, part: np.ndarray, motion: Motion) -> list[BVHTree]:
    """A part of the body, a mask (V,), in each frame, closed where it was cut off."""
    faces = body.faces[part[body.faces].all(axis=1)]
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


def inside(tree: BVHTree, points: np.ndarray) -> int:
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
