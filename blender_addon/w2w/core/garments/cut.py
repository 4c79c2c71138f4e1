# SPDX-License-Identifier: GPL-3.0-or-later
"""A loose T-shirt and loose trousers for any body: its skin there, moved off by some ease and smoothed."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from ..body.body import JOINT_INDEX, Body, edge_lengths, edges_of, midpoint, neighbours
from ..patches.body_parts import SIDES, in_part, sleeves, waist
from ..rotations import unit

KINDS = ("tshirt", "trousers")
"""All garments."""

BLEND = ".blend"

EASE = 0.025
"""How far the cloth is off the skin before it is draped, metres: some 16 cm more around than the body."""

SNUG, TAPER = 0.006, 0.08
"""Ease at the edge that holds the garment, and how far from it the full ease is reached, metres."""

HELD = 0.025
"""Cloth this near to that edge stays where the skin carries it, metres."""

ANKLE = 0.03
"""Where trousers end above the ankle, metres."""

SMOOTHINGS, NORMALS_SMOOTHED = 12, 4

CLOSEST = 0.9
"""Least distance from the skin after smoothing, in eases."""

APART = 0.003
"""How far each leg of trousers stays from the middle at least, metres."""


@dataclass(frozen=True, eq=False)
class Garment:
    """A garment in the body's rest pose: its mesh, skinned as the skin below it.

    `held` marks the vertices (V,) at the collar or the waistband, which go with the skin.
    """

    cloth: Body
    held: np.ndarray


def cut(kind: str, body: Body) -> Garment:
    """Cut a garment, one of `KINDS`, for a body in any shape, with any mesh.

    Raises `ValueError` if there is no such garment, or the body's mesh has nothing at its place.
    """
    if kind not in KINDS:
        raise ValueError(f"there is no garment called '{kind}': there are {' and '.join(KINDS)}")
    chosen = _shirt(body) if kind == "tshirt" else _trousers(body)
    skin, faces = _largest_piece(body.faces[chosen[body.faces].all(axis=1)], len(body.vertices))
    if len(skin) < 3:
        raise ValueError(f"the mesh of '{body.name}' has no surface where a {kind} goes")
    points = body.vertices[skin]
    edges = edges_of(faces)
    edge = _holding_edge(kind, points, faces)
    away = dijkstra(edge_lengths(points, edges), indices=edge, min_only=True)
    ease = np.interp(away, (0, TAPER), (SNUG, EASE))
    loose = points + ease[:, None] * _soft_normals(body, skin, _average(edges, len(skin)))
    off = points[:, 0] - body.joints[:, 0].mean()
    side = np.where((np.abs(off) > APART) & (kind == "trousers"), np.sign(off), 0.0)
    loose = _smoothed(loose, CLOSEST * ease, side, body, faces)
    cloth = Body(loose, faces, body.joints, body.weights[skin], name=kind)
    return Garment(cloth, away < HELD)


def split_name(garment: str) -> tuple[str, str]:
    """File and object of a garment written FILE.blend:OBJECT; without a file one of `KINDS`."""
    file, mark, name = garment.partition(f"{BLEND}:")
    return (file + BLEND, name) if mark else ("", garment)


def _shirt(body: Body) -> np.ndarray:
    """Vertices of the skin below a T-shirt."""
    hip = midpoint(body.joints, "hip")[2]
    return (in_part(body, "torso") & (body.vertices[:, 2] > hip)) | (sleeves(body) > 0)


def _trousers(body: Body) -> np.ndarray:
    """Vertices of the skin below trousers."""
    ankle = max(body.joints[JOINT_INDEX[f"{side}_ankle"]][2] for side in SIDES) + ANKLE
    height = body.vertices[:, 2]
    return (in_part(body, "torso") | in_part(body, "leg")) & (height > ankle) & (height < waist(body))


def _largest_piece(faces: np.ndarray, n_vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the largest connected piece, and its faces in their numbers."""
    if not len(faces):
        return np.empty(0, dtype=np.int64), faces
    pieces = connected_components(neighbours(edges_of(faces), n_vertices), directed=False)[1][faces[:, 0]]
    vertices, numbers = np.unique(faces[pieces == np.bincount(pieces).argmax()], return_inverse=True)
    return vertices, numbers.reshape(-1, 3)


def _borders(faces: np.ndarray) -> np.ndarray:
    """Edges that belong to one triangle only, shape (E, 2)."""
    edges, count = np.unique(np.sort(edges_of(faces), axis=1), axis=0, return_counts=True)
    return edges[count == 1]


def _holding_edge(kind: str, points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vertices of the edge that holds the garment: the highest, which is the waistband's or the collar's."""
    edges = _borders(faces)
    border = np.unique(edges)
    loops = connected_components(neighbours(edges, len(points)), directed=False)[1][border]
    height = points[border, 2].copy()
    if kind == "tshirt":  # in the T-pose the sleeves' ends are as high, but far from the middle
        height -= np.abs(points[border, 0] - np.median(points[:, 0]))
    means = {loop: height[loops == loop].mean() for loop in np.unique(loops)}
    return border[loops == max(means, key=means.__getitem__)]


def _soft_normals(body: Body, skin: np.ndarray, average: csr_matrix) -> np.ndarray:
    normals = body.vertex_normals[skin]
    for _ in range(NORMALS_SMOOTHED):
        normals = (normals + average @ normals) / 2
    return unit(normals)


def _average(edges: np.ndarray, n_vertices: int) -> csr_matrix:
    """Matrix that gives each vertex the mean of its neighbours."""
    links = neighbours(edges, n_vertices)
    return diags(1 / np.maximum(np.asarray(links.sum(axis=1)).ravel(), 1)) @ links


def _smoothed(
    points: np.ndarray, least: np.ndarray, side: np.ndarray, body: Body, faces: np.ndarray
) -> np.ndarray:
    """The cloth without folds, nowhere nearer to the skin than `least`, each leg on its side of the middle.

    `side` is 1 for vertices that stay on the left, -1 for those on the right, 0 for the rest. Edges are
    smoothed as lines, for they would shrink.
    """
    edges = _borders(faces)
    within = ~np.isin(np.arange(len(points)), edges)
    inner = diags(within.astype(float)) @ _average(edges_of(faces), len(points))
    average = inner + _average(edges, len(points))
    skin, middle = KDTree(body.vertices), body.joints[:, 0].mean()
    for _ in range(SMOOTHINGS):
        points = (points + average @ points) / 2
        near = skin.query(points)[1]
        depth = np.einsum("va,va->v", points - body.vertices[near], body.vertex_normals[near])
        points = points + np.maximum(least - depth, 0)[:, None] * body.vertex_normals[near]
        off = points[:, 0] - middle
        points[:, 0] = middle + np.where(side == 0, off, side * np.maximum(side * off, APART))
    return points
