# SPDX-License-Identifier: GPL-3.0-or-later
"""Isotropic remeshing of one half of the body to an exact number of near-equilateral triangles.

Splits, collapses, flips and tangential relaxation as in Botsch and Kobbelt 2004 (A remeshing
approach to multiresolution modeling, SGP), with an edge length that varies over the surface.
Relaxation goes to the centroid weighted by length^-4, so that the spacing follows the length.
The mirror seam is a curve of its own: its vertices only slide along it.
"""

from __future__ import annotations

import numpy as np

from .editable import MAX_VALENCE, EditableMesh
from .quality import smallest_angles
from .surface import Surface

TOO_LONG, TOO_SHORT = 4 / 3, 4 / 5
"""Edges beyond these shares of the wanted length are split or collapsed (Botsch and Kobbelt)."""

MIN_VALENCE = 4
POOR_ANGLE = np.deg2rad(30.0)

SETTLING_ROUNDS, ROUNDS, POLISH_ROUNDS = 6, 12, 24
"""Rounds at a fixed length, rounds in all, and rounds of relaxation at the exact count."""

RESPONSE = 0.4
"""How fast the length follows the count; 0.5 would answer in full, were nothing else to change."""

START_SCALE = 0.9
"""The first rounds work with shorter edges than wanted: thin parts that are lost never come back."""


def remesh_half(surface: Surface, n_faces: int) -> tuple[np.ndarray, np.ndarray]:
    """Remesh the half body.

    Parameters
    ----------
    surface : Surface
        The half on x >= 0, its boundary on x = 0, with the edge lengths wanted.
    n_faces : int
        Exact number of triangles; even.

    Returns
    -------
    vertices : ndarray, shape (V, 3)
        On the surface; those of the boundary on x = 0 exactly.
    faces : ndarray, shape (n_faces, 3)
    """
    mesh = EditableMesh(surface.vertices, surface.faces)
    scale = START_SCALE
    for turn in range(ROUNDS):
        _split_long(mesh, surface, scale)
        _collapse_short(mesh, surface, scale)
        _flip_for_valence(mesh)
        for _ in range(3):
            _relax(mesh, surface)
        if turn >= SETTLING_ROUNDS:
            scale *= (len(mesh.triangles) / n_faces) ** RESPONSE
    for turn in range(POLISH_ROUNDS):
        if turn < POLISH_ROUNDS / 2:
            _collapse_poor(mesh, surface)
            _reach_count(mesh, surface, n_faces)
            _flip_for_valence(mesh)
        _flip_for_angle(mesh)
        _relax(mesh, surface)
    return mesh.compact()


def _edge_lengths(mesh: EditableMesh, surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges (E, 2), their lengths relative to those wanted, and whether they lie on the boundary."""
    edges, counts = mesh.edges()
    points = np.array(mesh.points)
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    return edges, lengths / surface.lengths_at(points[edges].mean(axis=1)), counts == 1


def _split_long(mesh: EditableMesh, surface: Surface, scale: float) -> None:
    edges, lengths, at_seam = _edge_lengths(mesh, surface)
    chords = np.array(mesh.on_boundary)[edges].all(axis=1) & ~at_seam
    lengths[chords] = np.inf
    for index in np.argsort(-lengths, kind="stable"):
        if lengths[index] <= TOO_LONG * scale:
            break
        mesh.split(*edges[index].tolist())


def _collapse_short(mesh: EditableMesh, surface: Surface, scale: float) -> None:
    edges, lengths, _ = _edge_lengths(mesh, surface)
    order = np.argsort(lengths, kind="stable")
    _collapse(mesh, surface, edges[order[lengths[order] < TOO_SHORT * scale]], TOO_LONG * scale)


def _collapse(mesh: EditableMesh, surface: Surface, edges: np.ndarray, longest: float) -> None:
    """Collapse edges in turn, none next to one just collapsed; `longest` is relative to the wanted length."""
    wanted = surface.lengths_at(np.array(mesh.points)[edges].mean(axis=1)) if len(edges) else []
    touched: set[int] = set()
    for (a, b), length in zip(edges.tolist(), wanted, strict=True):
        if touched.isdisjoint((a, b)) and mesh.collapse(a, b, longest * length):
            touched |= {a, b}


def _collapse_poor(mesh: EditableMesh, surface: Surface) -> None:
    """Collapse the shortest edge of every triangle with an angle below `POOR_ANGLE`."""
    points, faces = np.array(mesh.points), mesh.faces()
    poor = faces[smallest_angles(points, faces) < POOR_ANGLE]
    sides = np.linalg.norm(points[poor] - points[np.roll(poor, -1, axis=1)], axis=2)
    first = sides.argmin(axis=1)
    rows = np.arange(len(poor))
    _collapse(mesh, surface, np.stack([poor[rows, first], poor[rows, (first + 1) % 3]], axis=1), 2.0)


def _reach_count(mesh: EditableMesh, surface: Surface, n_faces: int) -> None:
    """Split the longest or collapse the shortest edges until the count is exact."""
    while excess := len(mesh.triangles) - n_faces:
        edges, lengths, at_seam = _edge_lengths(mesh, surface)
        usable = np.flatnonzero(at_seam == bool(excess % 2))
        order = usable[np.argsort(lengths[usable] if excess > 0 else -lengths[usable], kind="stable")]
        if excess < 0:
            mesh.split(*edges[order[0]].tolist())
            continue
        wanted = surface.lengths_at(np.array(mesh.points)[edges[order]].mean(axis=1))
        next(i for i, edge in enumerate(edges[order].tolist()) if mesh.collapse(*edge, 2 * wanted[i]))


def _flip_for_valence(mesh: EditableMesh) -> None:
    """Flip edges where that brings the valences nearer to six."""
    for a, b in mesh.edges()[0].tolist():
        ends = mesh.flip_ends(a, b)
        if ends is None:
            continue
        error = 0
        for vertices, change in (((a, b), -1), (ends, 1)):
            for vertex in vertices:
                count = len(mesh.neighbours(vertex))
                error += (mesh.full_valence(vertex, count + change) - 6) ** 2
                error -= (mesh.full_valence(vertex, count) - 6) ** 2
        if error < 0:
            mesh.flip(a, b)


def _flip_for_angle(mesh: EditableMesh) -> None:
    """Flip edges that are not Delaunay: the two angles that face them sum to more than 180 degrees."""
    points = np.array(mesh.points)
    for a, b in _edges_not_delaunay(points, mesh.faces()).tolist():
        ends = mesh.flip_ends(a, b)
        if ends is None:
            continue
        gains = (mesh.full_valence(vertex, len(mesh.neighbours(vertex)) + 1) for vertex in ends)
        losses = (mesh.full_valence(vertex, len(mesh.neighbours(vertex)) - 1) for vertex in (a, b))
        if max(gains) <= MAX_VALENCE and min(losses) >= MIN_VALENCE:
            mesh.flip(a, b)


def _edges_not_delaunay(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    pairs, opposite = [], []
    for corner in range(3):
        apex, first, second = (faces[:, (corner + k) % 3] for k in range(3))
        u, v = points[first] - points[apex], points[second] - points[apex]
        cosine = np.einsum("na,na->n", u, v) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
        opposite.append(np.arccos(np.clip(cosine, -1, 1)))
        pairs.append(np.sort(np.stack([first, second], axis=1), axis=1))
    edges, inverse = np.unique(np.concatenate(pairs), axis=0, return_inverse=True)
    sums = np.bincount(inverse.ravel(), weights=np.concatenate(opposite))
    return edges[sums > np.pi + 1e-6]


def _relax(mesh: EditableMesh, surface: Surface) -> None:
    """Move every vertex towards the weighted centroid of its triangles, along the surface."""
    points, faces = np.array(mesh.points), mesh.faces()
    corners = points[faces]
    centroids = corners.mean(axis=1)
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weights = np.linalg.norm(doubled, axis=1) / surface.lengths_at(centroids) ** 4
    sums, total, normals = np.zeros_like(points), np.zeros(len(points)), np.zeros_like(points)
    for corner in range(3):
        np.add.at(sums, faces[:, corner], centroids * weights[:, None])
        np.add.at(total, faces[:, corner], weights)
        np.add.at(normals, faces[:, corner], doubled)
    inner = np.flatnonzero((total > 0) & ~np.array(mesh.on_boundary))
    normal = normals[inner] / np.linalg.norm(normals[inner], axis=1, keepdims=True)
    step = sums[inner] / total[inner, None] - points[inner]
    step -= np.einsum("na,na->n", step, normal)[:, None] * normal
    moved = surface.closest_facing(points[inner] + step, normal)[0]
    _relax_seam(mesh, surface, points)
    points[inner] = moved
    mesh.points = [tuple(point) for point in points.tolist()]


def _relax_seam(mesh: EditableMesh, surface: Surface, points: np.ndarray) -> None:
    """Slide the boundary vertices along the mirror seam, in place."""
    edges, counts = mesh.edges()
    seam = edges[counts == 1]
    middles = points[seam].mean(axis=1)
    lengths = np.linalg.norm(points[seam[:, 0]] - points[seam[:, 1]], axis=1)
    weights = lengths / surface.lengths_at(middles) ** 3
    sums, total = np.zeros_like(points), np.zeros(len(points))
    for end in range(2):
        np.add.at(sums, seam[:, end], middles * weights[:, None])
        np.add.at(total, seam[:, end], weights)
    vertices = np.unique(seam)
    points[vertices] = surface.closest_on_seam(sums[vertices] / total[vertices, None])
