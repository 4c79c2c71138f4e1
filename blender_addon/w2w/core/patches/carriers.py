# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose the three vertices that carry a patch: a triangle whose frame is steady when the body moves.

A frame on a sliver turns float noise into rotation noise, and where skin folds a small triangle
turns over. So the carrier of a patch is chosen among triples of vertices around its centre: tall
enough, near equilateral, facing outward and steady against its bone in a library of poses.
"""

from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_NAMES, N_JOINTS, PARENTS, Body
from ..motion.motion import Motion
from ..motion.skinning import frames_from_edges, joint_transforms, skin, skinning_transforms
from ..rotations import unit
from .strip_graph import StripGraph

RANGES: dict[str, tuple[tuple[float, float], ...]] = {
    "pelvis": ((0, 0), (0, 0), (0, 0)),
    "spine1": ((-5, 30), (-12, 12), (-12, 12)),
    "spine2": ((-5, 20), (-10, 10), (-15, 15)),
    "spine3": ((-5, 15), (-10, 10), (-15, 15)),
    "neck": ((-25, 25), (-20, 20), (-35, 35)),
    "head": ((-20, 20), (-15, 15), (-30, 30)),
    "hip": ((-110, 25), (-45, 15), (-30, 30)),
    "knee": ((0, 130), (0, 0), (-10, 10)),
    "ankle": ((-25, 40), (-15, 15), (-10, 10)),
    "foot": ((-30, 15), (0, 0), (0, 0)),
    "collar": ((-5, 5), (-25, 10), (-15, 15)),
    "shoulder": ((-50, 50), (-60, 80), (-110, 30)),
    "elbow": ((-70, 70), (0, 0), (-140, 0)),
    "wrist": ((0, 0), (-60, 60), (-25, 25)),
    "hand": ((0, 0), (0, 60), (0, 0)),
}
"""Least and largest angle (degrees) about the fixed x, y and z axes of the T-pose, for the left side.

About the active ranges of healthy adults (American Academy of Orthopaedic Surgeons, Joint
Motion, 1965), measured from the T-pose: x flexes hips (-) and knees (+), y lowers the arm (+),
z brings it forward and flexes the elbow (-).
"""


def random_poses(n: int, seed: int) -> Motion:
    """Poses, one a frame, whose joint angles are drawn evenly and independently from `RANGES`.

    The pelvis is at the origin; the frame rate means nothing.
    """
    rng = np.random.default_rng(seed)
    rotations = np.empty((n, N_JOINTS, 3, 3))
    for joint, name in enumerate(JOINT_NAMES):
        low, high = np.transpose(RANGES[name.split("_")[-1]])
        angles = rng.uniform(low, high, size=(n, 3))
        if name.startswith("right_"):
            angles *= (1, -1, -1)
        rotations[:, joint] = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    return Motion(rotations, np.zeros((n, 3)), rate=1)


MIN_HEIGHT = 0.004
"""Least height of a carrier triangle, metres, if the mesh offers one."""

NEAREST, SPREAD = 8, 8
"""Corners are sought among the nearest vertices and among some spread over `REACH`."""

REACH = 0.04
"""Radius around the centre, metres, within which corners are sought."""

FARTHEST = 0.025
"""Distance of a triangle's middle from its centre, metres, beyond which it serves only if all do."""

SLENDER = 0.75
"""Likeness to an equilateral triangle (its area over the sum of squared sides, 1 at best) below which
the same holds."""

SHORTLIST, LONG_LIST = 48, 240
"""Best-shaped triangles of a patch that are tried in the pose library: at first, and where unsteady."""

UNSTEADY = np.radians(30)
"""Patches whose triangle turns farther than this in the trial poses have more triangles tried."""

ROUND_TURN, TIGHT_TURN = np.radians(60), np.radians(30)
"""Turns that cost 1, as a poor shape does: at first, and for patches found unsteady."""

TRIAL_POSES, TRIAL_SEED = 24, 1

COST_DIGITS = 6
"""Costs are compared after rounding, so that equal ones go to the same triangle on every machine."""

CHUNK = 64


def carrier_triangles(body: Body, graph: StripGraph, centres: np.ndarray) -> np.ndarray:
    """The triangle (N, 3), int32, that carries each patch, near its centre.

    v1, v2, v3 are as in Blender's three-vertex parent: z outward, x along v2 - v1, which of the three sides
    runs most nearly along the bone.
    """
    poses = random_poses(TRIAL_POSES, TRIAL_SEED)
    chosen, turn = _steadiest(body, graph, centres, poses, SHORTLIST, ROUND_TURN)
    unsteady = np.flatnonzero(turn > UNSTEADY)
    if len(unsteady):
        chosen[unsteady], _ = _steadiest(body, graph, centres[unsteady], poses, LONG_LIST, TIGHT_TURN)
    return _along_bone(body, chosen).astype(np.int32)


def _steadiest(
    body: Body, graph: StripGraph, centres: np.ndarray, poses: Motion, shortlist: int, turn_unit: float
) -> tuple[np.ndarray, np.ndarray]:
    """The best of the `shortlist` best-shaped triangles, and its worst turn, radians."""
    chosen, turns = [], []
    for begin in range(0, len(centres), CHUNK):
        chunk = centres[begin : begin + CHUNK]
        triangles, shape_cost = _shortlist(body, chunk, _corners_to_try(graph, chunk), shortlist)
        turn = triangle_rotation_error(body, triangles.reshape(-1, 3), poses).reshape(shape_cost.shape)
        best = np.argmin(np.round(shape_cost + turn / turn_unit, COST_DIGITS), axis=1)
        chosen.append(triangles[np.arange(len(chunk)), best])
        turns.append(turn[np.arange(len(chunk)), best])
    return np.concatenate(chosen), np.concatenate(turns)


def triangle_rotation_error(body: Body, triangles: np.ndarray, poses: Motion) -> np.ndarray:
    """Worst rotation of triangles (N, 3) against the bone that moves them most, over some poses; radians.

    0 for a triangle that moves rigidly with its bone.
    """
    bone = body.weights[triangles].mean(axis=1).argmax(axis=1)
    turned = joint_transforms(body, poses)[0][:, bone]
    rest = _frames(body.vertices[None], triangles)[0]
    used, corners = np.unique(triangles, return_inverse=True)
    posed = skin(body, skinning_transforms(body, poses), used)
    frames = _frames(posed, corners.reshape(triangles.shape))
    # trace(bone^T frame rest^T) is the sum of the products of frame with bone @ rest
    cosine = (np.einsum("tnab,tnab->tn", frames, turned @ rest) - 1) / 2
    return np.arccos(np.clip(cosine.min(axis=0), -1, 1))


def _frames(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Rotations (T, N, 3, 3) of triangles' frames on vertices (T, V, 3)."""
    first = vertices[:, triangles[:, 0]]
    edge_x, edge_b = vertices[:, triangles[:, 1]] - first, vertices[:, triangles[:, 2]] - first
    return frames_from_edges(first, edge_x, edge_b)[..., :3, :3]


def _corners_to_try(graph: StripGraph, centres: np.ndarray) -> np.ndarray:
    """The nearest vertices of each centre and more, evenly by rank, out to `REACH` if that is enough."""
    count = NEAREST + SPREAD
    corners = np.empty((len(centres), count), dtype=np.int64)
    for row, nearest in enumerate(graph.neighbourhoods(centres, REACH, count)):
        # a tiny mesh has fewer; triangles with a corner twice have no area and are never chosen
        near = np.resize(nearest, max(len(nearest), count))
        corners[row, :NEAREST] = near[:NEAREST]
        corners[row, NEAREST:] = near[np.linspace(NEAREST, len(near) - 1, SPREAD).round().astype(int)]
    return corners


def _shortlist(
    body: Body, centres: np.ndarray, corners: np.ndarray, shortlist: int
) -> tuple[np.ndarray, np.ndarray]:
    """The best-shaped triangles of each patch, facing outward, and the cost of their shape."""
    triples = np.array(list(combinations(range(corners.shape[1]), 3)))
    points = body.vertices[corners] - body.vertices[centres][:, None]
    sides = np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)
    first, second, third = triples.T
    lengths = np.stack([sides[:, first, second], sides[:, second, third], sides[:, third, first]])
    normal = np.cross(points[:, second] - points[:, first], points[:, third] - points[:, first])
    double_area = np.maximum(np.linalg.norm(normal, axis=-1), np.finfo(float).tiny)
    height = double_area / lengths.max(axis=0)
    equilateral = 2 * np.sqrt(3) * double_area / (lengths**2).sum(axis=0)
    outward = np.einsum("ntk,nk->nt", normal, body.vertex_normals[centres]) / double_area
    offset = np.linalg.norm((points[:, first] + points[:, second] + points[:, third]) / 3, axis=-1)
    spacing = np.maximum(sides[:, 0, 1 : NEAREST - 1].mean(axis=1, keepdims=True), MIN_HEIGHT)
    too_low = np.where(height < MIN_HEIGHT, 2 - height / MIN_HEIGHT, 0)
    cost = 2 * (1 - equilateral) + 3 * (1 - np.abs(outward)) + 0.5 * offset / spacing + 100 * too_low
    cost += 10 * ((offset > FARTHEST) | (equilateral < SLENDER))
    best = np.argsort(np.round(cost, COST_DIGITS), axis=1, kind="stable")[:, :shortlist]
    triangles = np.take_along_axis(corners[:, None], triples[best], axis=2)
    inward = np.take_along_axis(outward, best, axis=1) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles, np.take_along_axis(cost, best, axis=1)


def _along_bone(body: Body, triangles: np.ndarray) -> np.ndarray:
    """Turn the corners' order so that x runs along the bone as nearly as the triangle allows."""
    bone = body.weights[triangles].mean(axis=1).argmax(axis=1)
    directions = np.empty((N_JOINTS, 3))  # of each joint's bone: to its children's mean or on from its parent
    for joint in range(N_JOINTS):
        children = [child for child in range(N_JOINTS) if PARENTS[child] == joint]
        end = body.joints[children].mean(axis=0) if children else body.joints[joint]
        directions[joint] = end - body.joints[joint if children else PARENTS[joint]]
    corners = body.vertices[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    along = np.einsum("nka,na->nk", sides, unit(directions)[bone]) / np.linalg.norm(sides, axis=2)
    start = np.argmax(np.round(along, COST_DIGITS), axis=1)
    return np.take_along_axis(triangles, (start[:, None] + np.arange(3)) % 3, axis=1)
