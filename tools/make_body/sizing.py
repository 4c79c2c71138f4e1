# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the edges shall be where: by curvature, with caps where sensors are worn."""

from __future__ import annotations

import igl
import numpy as np
from scipy import sparse

from w2w.core.body.body import JOINT_INDEX, N_JOINTS

SHORTEST = 0.0054
"""Shortest edge wanted, metres: its triangles are 4.7 mm high, and a stable sensor needs 4 mm."""

GRADATION = 0.25
"""Largest change of the wanted length per metre along the surface."""

LONGEST = 0.026
"""Longest edge anywhere, metres."""

PART_CAPS: dict[str, float] = {
    "head": 0.0135,
    "neck": 0.017,
    "wrist": 0.012,
    "ankle": 0.015,
    "foot": 0.013,
    "spine1": 0.021,
    "spine2": 0.021,
}
"""Longest edge, metres, on what a joint carries (scalp, neck, hand, foot, waist)."""

BAND_CAPS: dict[str, tuple[float, float]] = {
    "wrist": (0.05, 0.010),
    "ankle": (0.06, 0.012),
    "elbow": (0.05, 0.016),
    "knee": (0.07, 0.019),
}
"""Within how many metres of a joint edges are at most how long: straps, and creases that bend."""

EAR_CAP = 0.0058
"""Longest edge on the ear, metres."""

FINER: dict[str, float] = {"head": 1.5, "foot": 1.5}
"""Parts whose curvature counts so many times: the face and the toes."""


def length_caps(
    vertices: np.ndarray, joints: np.ndarray, weights: np.ndarray, ears: np.ndarray
) -> np.ndarray:
    """Longest edge allowed at each vertex of the left half.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    joints : ndarray, shape (24, 3)
    weights : ndarray, shape (V, 24)
    ears : ndarray of bool, shape (V,)

    Returns
    -------
    ndarray, shape (V,)
        Metres.
    """
    caps = _by_part(weights, PART_CAPS, LONGEST)
    for part, (reach, cap) in BAND_CAPS.items():
        near = np.linalg.norm(vertices - joints[_left(part)], axis=1) < reach
        caps[near] = np.minimum(caps[near], cap)
    caps[ears] = EAR_CAP
    return caps


def detail(weights: np.ndarray) -> np.ndarray:
    """How much more the curvature counts at each vertex, shape (V,)."""
    return _by_part(weights, FINER, 1.0)


def _by_part(weights: np.ndarray, values: dict[str, float], otherwise: float) -> np.ndarray:
    """Value of the part that holds each vertex most, shape (V,)."""
    of_joint = np.full(N_JOINTS, otherwise)
    for part, value in values.items():
        of_joint[_left(part)] = value
    return of_joint[weights.argmax(axis=1)]


def _left(part: str) -> int:
    left = f"left_{part}"
    return JOINT_INDEX[left if left in JOINT_INDEX else part]


def wanted_lengths(
    vertices: np.ndarray, faces: np.ndarray, caps: np.ndarray, detail: np.ndarray, n_faces: int
) -> np.ndarray:
    """Edge lengths that follow the curvature and add up to about `n_faces` triangles.

    A triangle of edge L stays within about k L^2 / 6 of a surface of curvature k, so
    L = sqrt(6 e / k) for a tolerance e (Dunyach et al. 2013, Adaptive remeshing for
    real-time mesh deformation, Eurographics short papers); e is found by bisection.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
        The left half of the source body in the T-pose.
    faces : ndarray, shape (F, 3)
    caps : ndarray, shape (V,)
        Longest edge allowed, metres.
    detail : ndarray, shape (V,)
        Factor on the curvature.
    n_faces : int
        Triangles wanted.

    Returns
    -------
    ndarray, shape (V,)
    """
    curvature = _largest_curvature(vertices, faces) * detail
    areas = igl.doublearea(vertices, faces).ravel() / 2
    low, high = 1e-7, 1e-1
    for _ in range(40):
        tolerance = np.sqrt(low * high)
        lengths = np.clip(np.sqrt(6 * tolerance / curvature), SHORTEST, caps)
        lengths = _graded(lengths, vertices, faces)
        expected = (areas * 4 / np.sqrt(3) / lengths[faces].mean(axis=1) ** 2).sum()
        low, high = (tolerance, high) if expected > n_faces else (low, tolerance)
    return lengths


def _largest_curvature(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Largest absolute principal curvature, 1/m, smoothed over a few neighbours."""
    first, second = igl.principal_curvature(vertices, faces, 4)[2:4]
    curvature = np.maximum(np.abs(first), np.abs(second)).ravel()
    adjacency = igl.adjacency_matrix(faces).astype(float)
    average = sparse.diags(1 / np.asarray(adjacency.sum(axis=1)).ravel()) @ adjacency
    for _ in range(4):
        curvature = (curvature + average @ curvature) / 2
    return np.maximum(curvature, 1e-3)


def _graded(lengths: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Largest field below `lengths` whose slope along edges is at most `GRADATION`."""
    edges = igl.edges(faces)
    steps = GRADATION * np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    graded = lengths.copy()
    while True:
        before = graded.copy()
        np.minimum.at(graded, edges[:, 0], before[edges[:, 1]] + steps)
        np.minimum.at(graded, edges[:, 1], before[edges[:, 0]] + steps)
        if np.array_equal(graded, before):
            return graded
