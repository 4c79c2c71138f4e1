# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses in which cloth has room: nothing can lie between parts of the body that overlap.

A recorded pose on a body of another build sinks hanging arms some centimetres into trunk and hips. The run-up
that leads to a clip's first pose was recorded by nobody: legs that swing past each other may be through each
other there, and arms in the trunk.
"""

from dataclasses import replace

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from scipy.spatial.transform import Rotation

from ...core.body.body import JOINT_INDEX, Body
from ...core.motion.motion import Motion
from ...core.motion.run_up import reached_back
from ...core.motion.skinning import skin, skinning_transforms

ANGLES = np.arange(0.0, 16.0, 3.0)
"""Angles by which an arm may be turned outward, degrees."""

ARM_AS_CLEAR = 0.05
"""Share of the overlap that a smaller angle may leave beyond the least that any leaves."""

SIDES = {"left": -1.0, "right": 1.0}

REACHES = (1.0, 0.5, 0.25, 0.125)
"""Shares of the whole run-up that are tried: from the calmest to the shortest."""

RUN_UP_AS_CLEAR = 0.01
"""Share of the vertices looked at by which more may be sunk than in the clip's first pose."""

ARM, LEG = ("shoulder", "elbow", "wrist", "hand"), ("hip", "knee", "ankle", "foot")
"""Joints of a limb, from the trunk on."""

ROOM = 0.016
"""Left between two parts for two layers of cloth, metres."""

RAY = Vector((0.37, 0.61, 0.70)).normalized()
"""Along no axis, so that rays seldom meet an edge."""


def with_clear_arms(body: Body, motion: Motion) -> Motion:
    """A motion with each arm turned outward at the shoulder, throughout, as far as it takes to be clear."""
    return replace(motion, rotations=_turned(motion, {side: outward(body, motion, side) for side in SIDES}))


def outward(body: Body, motion: Motion, side: str) -> float:
    """The least of `ANGLES`, in degrees, that leaves a left or right arm next to no overlap in ten frames."""
    frames = np.unique(np.linspace(0, motion.n_frames - 1, 10).round().astype(int))
    pelvis = motion.pelvis[frames] - motion.pelvis[frames[0]]  # single precision is finest at the origin
    few = replace(motion, rotations=motion.rotations[frames], pelvis=pelvis)
    trunks = closed(body, trunk(body), few)
    arm = limb(body, side, ARM)
    sunk = []
    for angle in ANGLES:
        points = pushed_out(body, arm, replace(few, rotations=_turned(few, {side: angle})))
        sunk.append(sum(inside(tree, own) for tree, own in zip(trunks, points, strict=True)))
        if not sunk[-1]:
            break
    bearable = min(sunk) + ARM_AS_CLEAR * sunk[0]
    return float(ANGLES[np.flatnonzero(np.array(sunk) <= bearable)[0]])


def clear_reach(body: Body, motion: Motion) -> float:
    """The longest of `REACHES` with hardly more overlap than the clip's first pose has; else the shortest."""
    for reach in REACHES:
        sunk, total = _sunk(body, reached_back(motion, reach))
        if reach == REACHES[0]:
            bearable = sunk[-1] + RUN_UP_AS_CLEAR * total
        if max(sunk) <= bearable:
            return reach
    return REACHES[-1]


def moved_by(body: Body, side: str, joints: tuple[str, ...]) -> np.ndarray:
    """Vertices that follow the bones of a limb most, as a mask (V,)."""
    return np.isin(body.weights.argmax(axis=1), [JOINT_INDEX[f"{side}_{name}"] for name in joints])


def trunk(body: Body) -> np.ndarray:
    """Vertices of the body without its arms, as a mask (V,)."""
    return ~(moved_by(body, "left", ARM) | moved_by(body, "right", ARM))


def limb(body: Body, side: str, joints: tuple[str, ...]) -> np.ndarray:
    """One in three of the vertices of a limb that can be clear of the body."""
    root, bend = (body.joints[JOINT_INDEX[f"{side}_{name}"]] for name in joints[:2])
    bone = bend - root
    along = (body.vertices - root) @ bone / (bone @ bone)
    # nearer to the trunk skin always meets skin
    return np.flatnonzero(moved_by(body, side, joints) & (along > 0.4))[::3]


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
    middles = np.stack([posed[:, rim].mean(axis=1) for rim in rims], axis=1)
    poses = np.concatenate([posed, middles], axis=1).tolist()
    return [BVHTree.FromPolygons(points, whole) for points in poses]


def inside(tree: BVHTree, points: np.ndarray) -> int:
    """Number of points inside a closed surface."""
    return sum(times_inside(tree, Vector(point)) > 0 for point in points.tolist())


def times_inside(tree: BVHTree, point: Vector) -> int:
    """Times that a ray from a point leaves a closed surface minus times that it enters it.

    Once if the point is inside, twice if two parts of the surface overlap there.
    """
    turns = 0
    while True:
        place, normal, _, _ = tree.ray_cast(point, RAY)
        if place is None:
            return turns
        turns += 1 if normal.dot(RAY) > 0 else -1
        point = place + 1e-5 * RAY  # on from beyond the face


def _turned(motion: Motion, degrees: dict[str, float]) -> np.ndarray:
    rotations = motion.rotations.copy()
    for side, angle in degrees.items():
        turn = Rotation.from_euler("y", SIDES[side] * angle, degrees=True).as_matrix()
        joint = JOINT_INDEX[f"{side}_shoulder"]
        rotations[:, joint] = turn @ rotations[:, joint]
    return rotations


def _sunk(body: Body, poses: Motion) -> tuple[list[int], int]:
    """Vertices sunk in each pose, and their total: arms in the rest of the body, one leg in the other."""
    sunk, total = [0] * poses.n_frames, 0
    trunks, left_legs = (closed(body, part, poses) for part in (trunk(body), moved_by(body, "left", LEG)))
    for trees, side, joints in ((trunks, "left", ARM), (trunks, "right", ARM), (left_legs, "right", LEG)):
        vertices = limb(body, side, joints)
        total += len(vertices)
        for number, (tree, own) in enumerate(zip(trees, pushed_out(body, vertices, poses), strict=True)):
            sunk[number] += inside(tree, own)
    return sunk, total


def _caps(faces: np.ndarray, n_vertices: int) -> tuple[list[tuple[int, int, int]], list[list[int]]]:
    """Triangles from each rim of a surface to a further vertex in its middle, and the rims."""
    sides = {(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}
    onward = {b: a for a, b in sides if (b, a) not in sides}
    caps: list[tuple[int, int, int]] = []
    rims: list[list[int]] = []
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
