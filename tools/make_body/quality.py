# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures that say how good a body's mesh and weights are."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, MIRRORED_JOINTS, N_JOINTS, Body
from w2w.core.body.shapes import volume
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import skin, skinning_transforms

POSES: dict[str, tuple[str, tuple[float, float, float]]] = {
    "arms down": ("shoulder", (0.0, np.deg2rad(80.0), 0.0)),
    "elbow 100": ("elbow", (0.0, 0.0, -np.deg2rad(100.0))),
    "knee 100": ("knee", (np.deg2rad(100.0), 0.0, 0.0)),
    "hip 90": ("hip", (-np.deg2rad(90.0), 0.0, 0.0)),
}
"""Joint turned on both sides, and the rotation vector of the left one."""


@dataclass(frozen=True)
class Figures:
    """What is asked of the bundled body, measured."""

    n_vertices: int
    n_faces: int
    closed: bool
    euler_characteristic: int
    n_components: int
    mirror_error: float
    self_intersecting_faces: int
    min_angle_median: float
    min_angle_p5: float
    min_angle_lowest: float
    max_valence: int
    faces_4mm_high: float
    volume: float
    volume_change: dict[str, float]


def measure(body: Body) -> Figures:
    """All figures of a body; angles in degrees, lengths in metres, changes of volume as fractions."""
    angles = np.rad2deg(smallest_angles(body.vertices, body.faces))
    edges = unique_edges(body.faces)
    n_used = len(np.unique(body.faces))
    rest = volume(body.vertices, body.faces)
    return Figures(
        n_vertices=len(body.vertices),
        n_faces=len(body.faces),
        closed=is_closed(body.faces),
        euler_characteristic=n_used - len(edges) + len(body.faces),
        n_components=count_components(body.faces, len(body.vertices)),
        mirror_error=mirror_error(body),
        self_intersecting_faces=len(self_intersections(body.vertices, body.faces)),
        min_angle_median=float(np.median(angles)),
        min_angle_p5=float(np.percentile(angles, 5)),
        min_angle_lowest=float(angles.min()),
        max_valence=int(np.bincount(edges.ravel()).max()),
        faces_4mm_high=float((smallest_heights(body.vertices, body.faces) >= 0.004).mean()),
        volume=rest,
        volume_change={name: volume(pose(body, name), body.faces) / rest - 1 for name in POSES},
    )


def report(body: Body) -> str:
    """The figures as text, a line each."""
    return "\n".join(f"{name}: {value}" for name, value in asdict(measure(body)).items())


def unique_edges(faces: np.ndarray) -> np.ndarray:
    """Edges of a triangle mesh, smaller index first, shape (E, 2)."""
    pairs = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(pairs, axis=0)


def is_closed(faces: np.ndarray) -> bool:
    """Whether every edge has two faces that run along it in opposite directions."""
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    once = len(np.unique(directed, axis=0)) == len(directed)
    return bool(once and np.array_equal(np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0)))


def count_components(faces: np.ndarray, n_vertices: int) -> int:
    """Number of connected parts, vertices without a face included."""
    edges = unique_edges(faces)
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(n_vertices, n_vertices))
    return int(connected_components(graph, directed=False)[0])


def mirror_error(body: Body) -> float:
    """Largest distance between a vertex's mirror image and its partner, metres.

    Infinite if there is no mirror map or it does not carry the faces onto each other.
    """
    if body.mirror is None or not np.array_equal(body.mirror[body.mirror], np.arange(len(body.vertices))):
        return float("inf")
    mirrored = np.sort(body.mirror[body.faces], axis=1)
    if not np.array_equal(np.unique(mirrored, axis=0), np.unique(np.sort(body.faces, axis=1), axis=0)):
        return float("inf")
    points = body.vertices * [-1, 1, 1] - body.vertices[body.mirror]
    joints = body.joints * [-1, 1, 1] - body.joints[list(MIRRORED_JOINTS)]
    return float(max(np.linalg.norm(points, axis=1).max(), np.linalg.norm(joints, axis=1).max()))


def smallest_angles(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Smallest angle of each triangle, radians, shape (F,)."""
    corners = points[faces]
    sides = np.sort(np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2), axis=1)
    a, b, c = sides.T
    return np.arccos(np.clip((b**2 + c**2 - a**2) / np.maximum(2 * b * c, 1e-30), -1, 1))


def smallest_heights(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Smallest height of each triangle, metres, shape (F,)."""
    corners = points[faces]
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return doubled / np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)


def pose(body: Body, name: str) -> np.ndarray:
    """Vertices in one of `POSES`, both sides alike, shape (V, 3)."""
    part, left = POSES[name]
    right = np.array(left) * [1, -1, -1]
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    rotations[0, JOINT_INDEX[f"left_{part}"]] = Rotation.from_rotvec(left).as_matrix()
    rotations[0, JOINT_INDEX[f"right_{part}"]] = Rotation.from_rotvec(right).as_matrix()
    motion = Motion(rotations, body.joints[:1], rate=60.0)
    return skin(body, skinning_transforms(body, motion))[0]


def self_intersections(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Faces that another face pierces, shape (K,).

    Pairs that share an edge are left out; of pairs that share a vertex only the edges
    opposite to it are tried. Moeller and Trumbore 1997 for an edge against a triangle.
    """
    first, second = _close_pairs(points, faces).T
    shared = (faces[first][:, :, None] == faces[second][:, None, :]).any(axis=2).sum(axis=1)
    first, second = first[shared < 2], second[shared < 2]
    hit = np.zeros(len(first), dtype=bool)
    for one, other in ((first, second), (second, first)):
        for corner in range(3):
            start, end = faces[one, corner], faces[one, (corner + 1) % 3]
            apart = (faces[other] != start[:, None]).all(axis=1) & (faces[other] != end[:, None]).all(axis=1)
            hit[apart] |= _pierces(points[start[apart]], points[end[apart]], points[faces[other[apart]]])
    return np.unique(np.concatenate([first[hit], second[hit]]))


def _close_pairs(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Pairs of faces whose bounding boxes overlap, shape (P, 2)."""
    corners = points[faces]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max()
    pairs = cKDTree(centres).query_pairs(2 * reach, output_type="ndarray")
    low, high = corners.min(axis=1), corners.max(axis=1)
    overlap = (low[pairs[:, 0]] <= high[pairs[:, 1]]) & (low[pairs[:, 1]] <= high[pairs[:, 0]])
    return pairs[overlap.all(axis=1)]


def _pierces(start: np.ndarray, end: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Whether segments (N, 3) pass through triangles (N, 3, 3), shape (N,)."""
    along = end - start
    u_edge, v_edge = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(along, v_edge)
    determinant = np.einsum("na,na->n", u_edge, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = start - triangles[:, 0]
        u = np.einsum("na,na->n", offset, across) / determinant
        turned = np.cross(offset, u_edge)
        v = np.einsum("na,na->n", along, turned) / determinant
        t = np.einsum("na,na->n", v_edge, turned) / determinant
        return (determinant != 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)
