# SPDX-License-Identifier: GPL-3.0-or-later
"""Non-rigid registration: lay the bundled body on another body's surface, to hand over rig and weights.

First the skeleton: joint rotations and one scale a body part, by Gauss-Newton on landmarks and then
on closest points (articulated ICP). Then the skin: every vertex moves to the target's surface under
a smooth displacement field (after Amberg, Romdhani and Vetter 2007, doi:10.1109/CVPR.2007.383165),
first stiff, then softer.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag
from scipy.sparse import csr_matrix, diags, identity
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..body.body import (
    MIRRORED_JOINTS,
    N_JOINTS,
    PARENTS,
    Body,
    edges_of,
    face_normals,
    neighbours,
    vertex_normals,
)
from ..rotations import unit

N_POSE = 3 * N_JOINTS
"""Parameters before the root's translation: a rotation vector for each joint."""

TURN_PRIOR = 0.01
SCALE_PRIOR = 0.05
"""Metres of surface distance that a turn by a radian, or a scale by a factor e, is worth."""

LANDMARK_WEIGHT = 0.3
"""Trust in landmarks, which are a centimetre or two apart on two bodies, once surfaces can be matched."""

LANDMARK_STEPS, SURFACE_STEPS = 12, 20
"""Gauss-Newton steps on landmarks alone, and on closest points found again at every step."""

TOWARDS_POINT = 0.2
"""Pull along the surface, towards the closest point itself, against the pull across it."""

SKELETON_SAMPLE = 5
"""Every fifth vertex is enough to fit the skeleton."""

STIFFNESS = (300.0, 100.0, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.01)
"""Weight of the displacement's smoothness against the match, round after round."""

THERE = 0.3
"""Weight of matching template vertices to target triangles, against target vertices to template triangles."""

NEAREST_FACES = 8
"""Number of faces with the nearest middles among which the closest point is searched."""

SAME_SIDE = 0.3
"""Least cosine between the normals of a point and its match: skin matches skin of the same side."""

REACH = 0.08
"""Points farther apart than this, metres, do not match."""


class ClosestPoints:
    """Closest points on a triangle mesh of vertices (V, 3) and faces (F, 3)."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices, self.faces = vertices, faces
        self.face_normals = unit(face_normals(vertices[faces]))
        self.tree = cKDTree(vertices[faces].mean(axis=1))

    def closest(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Closest points (N, 3) on the side that faces the same way, their faces and distances (N,).

        A distance is infinite if no near face looks the same way.
        """
        _, near = self.tree.query(points, k=NEAREST_FACES)
        nearest, distance = closest_on(self.vertices[self.faces[near]], points)
        same_side = np.einsum("nka,na->nk", self.face_normals[near], normals) > SAME_SIDE
        distance = np.where(same_side, distance, np.inf)
        rows, best = np.arange(len(points)), distance.argmin(axis=1)
        return nearest[rows, best], near[rows, best], distance[rows, best]

    def shares(self, points: np.ndarray, faces: np.ndarray) -> csr_matrix:
        """Barycentric coordinates (N, V) of points (N, 3) that lie on given faces (N,)."""
        share = shares_on(self.vertices[self.faces[faces]], points)
        places = (share.ravel(), (np.repeat(np.arange(len(points)), 3), self.faces[faces].ravel()))
        return csr_matrix(places, shape=(len(points), len(self.vertices)))


def closest_on(triangles: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Closest points (N, K, 3) on K triangles (N, K, 3, 3) for each of some points (N, 3), and distances."""
    from trimesh.triangles import closest_point  # imported when used: it takes longer than W2W's panel

    repeated = np.repeat(points, triangles.shape[1], axis=0)
    nearest = closest_point(triangles.reshape(-1, 3, 3), repeated)
    # faces that share the closest point are equally near: a last bit must not choose between them
    distance = np.linalg.norm(nearest - repeated, axis=1).round(9)
    return nearest.reshape(*triangles.shape[:2], 3), distance.reshape(triangles.shape[:2])


def shares_on(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (N, 3) of points (N, 3) that lie on triangles (N, 3, 3).

    A triangle without an area gets those of any of its points.
    """
    from trimesh.triangles import points_to_barycentric

    with np.errstate(divide="ignore", invalid="ignore"):
        shares = points_to_barycentric(triangles, points, method="cross")
    shares = np.clip(np.nan_to_num(shares, nan=1.0), 0, 1)
    return shares / shares.sum(axis=1, keepdims=True)


def register(
    template: Body, vertices: np.ndarray, faces: np.ndarray, landmarks: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lay a template body on a target mesh and hand its rig and weights over.

    The target's vertices (T, 3) are in the template's axes, metres, its triangles (F, 3) counter-clockwise
    seen from outside. Landmarks (L,) are template vertices and target vertices that mark the same places.

    Returns the template's joints (24, 3) carried along, skinning weights (T, 24) of the target's vertices,
    and their distances (T,) from the template once that is laid on the target, metres.
    """
    target = ClosestPoints(vertices, faces)
    posed = _fit_skeleton(template, target, (landmarks[0], vertices[landmarks[1]]))
    skin = _fit_skin(posed, template.faces, target)
    registered = ClosestPoints(skin, template.faces)
    closest, face, distance = registered.closest(vertices, vertex_normals(vertices, faces))
    weights = registered.shares(closest, face) @ template.weights
    lost = ~np.isfinite(distance)
    if lost.any():  # deep in folds normals look every way: take what is near
        distance[lost], nearest = cKDTree(skin).query(vertices[lost])
        weights[lost] = template.weights[nearest]
    return carried_joints(template, skin), weights, distance


def carried_joints(body: Body, vertices: np.ndarray) -> np.ndarray:
    """Joints (24, 3) of a body whose vertices have been moved.

    Each joint goes with the similarity transform of the skin around it: of the vertices that it and its
    parent move together.
    """
    joints = np.empty((N_JOINTS, 3))
    for joint in range(N_JOINTS):
        others = [PARENTS[joint]] if joint else [child for child in range(N_JOINTS) if PARENTS[child] == 0]
        influence = body.weights[:, joint] * body.weights[:, others].sum(axis=1)
        joints[joint] = _similarity(body.vertices, vertices, influence, body.joints[joint])
    return joints


def _similarity(start: np.ndarray, end: np.ndarray, influence: np.ndarray, point: np.ndarray) -> np.ndarray:
    """A point moved by the weighted best similarity transform (Umeyama 1991, doi:10.1109/34.88573)."""
    share = influence / influence.sum()
    middle, goal = share @ start, share @ end
    spread = start - middle
    u, sizes, vt = np.linalg.svd((spread * share[:, None]).T @ (end - goal))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = (sizes * signs).sum() / (share @ (spread**2).sum(axis=1))
    return goal + scale * ((point - middle) @ (u * signs) @ vt)


def _fit_skeleton(template: Body, target: ClosestPoints, marks: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """The template's vertices, posed and scaled part by part to lie near the target."""
    marked = _Posable(template, marks[0])
    sampled = _Posable(template, np.arange(0, len(template.vertices), SKELETON_SAMPLE))
    whole = _Posable(template)
    parameters = np.zeros(N_POSE + 3 + N_JOINTS)
    parameters[N_POSE : N_POSE + 3] = (marks[1] - template.vertices[marks[0]]).mean(axis=0)
    for _ in range(LANDMARK_STEPS):
        gap, slope = _linearised(marked, parameters)
        parameters = _step(parameters, [((gap - marks[1]).ravel(), slope.reshape(gap.size, -1))])
    for _ in range(SURFACE_STEPS):
        points, slope = _linearised(sampled, parameters)
        normals = vertex_normals(whole(parameters), template.faces)[::SKELETON_SAMPLE]
        goal, face, distance = target.closest(points, normals)
        trust = np.where(distance < REACH, np.sqrt(len(marks[0]) / len(points)), 0.0)
        across = trust[:, None] * target.face_normals[face]
        gap = points - goal
        towards = TOWARDS_POINT * trust[:, None]
        at_marks, mark_slope = _linearised(marked, parameters)
        off = LANDMARK_WEIGHT * (at_marks - marks[1]).ravel()
        terms = [
            (np.einsum("na,na->n", across, gap), np.einsum("na,nap->np", across, slope)),
            ((towards * gap).ravel(), (towards[..., None] * slope).reshape(gap.size, -1)),
            (off, LANDMARK_WEIGHT * mark_slope.reshape(off.size, -1)),
        ]
        parameters = _step(parameters, terms)
    return whole(parameters)


def _linearised(posable: _Posable, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (N, 3) under some parameters and their derivatives (N, 3, P), by differences."""
    size = 1e-6
    varied = posable(parameters + size * np.vstack([np.zeros(len(parameters)), np.eye(len(parameters))]))
    return varied[0], np.moveaxis(varied[1:] - varied[0], 0, -1) / size


def _step(parameters: np.ndarray, terms: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """One Gauss-Newton step on residuals and their slopes, with the priors on turns and scales."""
    normal = _prior()
    right = -normal @ parameters
    for residual, slope in terms:
        normal = normal + slope.T @ slope
        right = right - slope.T @ residual
    return parameters + np.linalg.solve(normal, right)


def _prior() -> np.ndarray:
    """Quadratic form that keeps turns small, and scales near their mean and equal left and right."""
    turns = np.zeros(N_POSE + 3)
    turns[3:N_POSE] = TURN_PRIOR**2
    from_mean = np.eye(N_JOINTS) - 1 / N_JOINTS
    from_mirror = np.eye(N_JOINTS) - np.eye(N_JOINTS)[list(MIRRORED_JOINTS)]
    scales = SCALE_PRIOR**2 * (from_mean + from_mirror.T @ from_mirror)
    return block_diag(np.diag(turns), scales)


class _Posable:
    """Some vertices of a body under pose, place and one scale a body part."""

    def __init__(self, body: Body, vertices: np.ndarray | slice = slice(None)) -> None:
        self.joints = body.joints
        weights = body.weights[vertices]
        homogeneous = np.concatenate([body.vertices[vertices], np.ones((len(weights), 1))], axis=1)
        self.rows = (weights[:, :, None] * homogeneous[:, None, :]).reshape(len(weights), -1)

    def __call__(self, parameters: np.ndarray) -> np.ndarray:
        """Positions (..., N, 3) under parameters (..., P)."""
        many = parameters.shape[:-1]
        turns = Rotation.from_rotvec(parameters[..., :N_POSE].reshape(-1, 3)).as_matrix()
        turns = turns.reshape(*many, N_JOINTS, 3, 3)
        scales = np.exp(parameters[..., N_POSE + 3 :])
        places = np.empty((*many, N_JOINTS, 3))
        places[..., 0, :] = self.joints[0] + parameters[..., N_POSE : N_POSE + 3]
        for joint in range(1, N_JOINTS):
            parent = PARENTS[joint]
            turns[..., joint, :, :] = turns[..., parent, :, :] @ turns[..., joint, :, :]
            offset = turns[..., parent, :, :] @ (self.joints[joint] - self.joints[parent])
            places[..., joint, :] = places[..., parent, :] + scales[..., parent, None] * offset
        linear = scales[..., None, None] * turns
        transforms = np.empty((*many, N_JOINTS, 4, 3))
        transforms[..., :3, :] = linear.swapaxes(-1, -2)
        transforms[..., 3, :] = places - np.einsum("...jab,jb->...ja", linear, self.joints)
        return self.rows @ transforms.reshape(*many, -1, 3)


def _fit_skin(posed: np.ndarray, faces: np.ndarray, target: ClosestPoints) -> np.ndarray:
    """Displace vertices onto the target, smoothly.

    Matching vertices to the target's flat triangles cuts its rounded parts short, so the target's
    own vertices are matched to the template's triangles as well.
    """
    joined = neighbours(edges_of(faces), len(posed))
    laplacian = identity(len(posed)) - diags(1 / np.asarray(joined.sum(axis=1)).ravel()) @ joined
    smoothness = (laplacian.T @ laplacian).tocsr()
    target_normals = vertex_normals(target.vertices, target.faces)
    skin = posed
    for stiffness in STIFFNESS:
        goal, _, distance = target.closest(skin, vertex_normals(skin, faces))
        trust = THERE * (distance < REACH)
        surface = ClosestPoints(skin, faces)
        closest, face, distance = surface.closest(target.vertices, target_normals)
        near = np.flatnonzero(distance < REACH)
        share = surface.shares(closest[near], face[near])
        system = stiffness * smoothness + diags(trust) + share.T @ share + 1e-6 * identity(len(posed))
        wanted = trust[:, None] * (goal - posed) + share.T @ (target.vertices[near] - share @ posed)
        skin = posed + splu(system.tocsc()).solve(wanted)
    return skin
