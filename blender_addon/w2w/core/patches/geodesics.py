# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact geodesic distances on a triangle mesh, solved only where they can matter.

The distances are those of Mitchell, Mount and Papadimitriou (1987, doi:10.1137/0216045) in the
form of Surazhsky et al. (2005, doi:10.1145/1073204.1073228), computed by `pygeodesic`.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from scipy.spatial import cKDTree


class ExactSolver:
    """Exact polyhedral geodesic distances, solved only where they can matter.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray, shape (F, 3)
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices = np.asarray(vertices, dtype=np.float64)
        self.faces = np.asarray(faces, dtype=np.int32)
        self._reach = _longest_edge_at_vertices(self.vertices, self.faces)
        self._tree = cKDTree(self.vertices)
        corners = self.faces.ravel()
        self._corner_faces = np.argsort(corners, kind="stable") // 3
        self._corner_starts = np.concatenate([[0], np.cumsum(np.bincount(corners, minlength=len(vertices)))])
        self._beyond = _faces_beyond(self.faces)
        self._local_index = np.zeros(len(self.vertices), dtype=np.int32)
        self._place = np.zeros(len(self.faces), dtype=np.int64)

    def distances(self, source: int) -> np.ndarray:
        """Distance of every vertex from `source`, shape (V,); inf where there is no way."""
        distance = np.full(len(self.vertices), np.inf)
        inside, values = self.closer(source, distance)
        distance[inside] = values
        return distance

    def closer(self, source: int, distance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances from `source` wherever they may lie below `distance`.

        If d(s, v) < distance(v), where `distance` is a distance to earlier sources, then the
        same holds all along the geodesic from s to v. A face that it crosses at p has
        d(s, p) < distance(p), so each corner c of the face has
        ``|s - c| < distance(c) + 2 * longest edge``. Faces without such corners are left
        out, and the exact solution on the small rest is exact on the whole.

        Parameters
        ----------
        source : int
        distance : ndarray, shape (V,)
            Exact distance to the nearest earlier source, inf where there is none.

        Returns
        -------
        vertices : ndarray of int, shape (K,)
        values : ndarray, shape (K,)
            Never below the true distance, and equal to it where that is below `distance`.
        """
        inside, faces = self._submesh(source, self._candidates(source, distance))
        if len(faces) == 0:
            # no other vertex is nearer to this source than to an earlier one
            return np.array([source]), np.zeros(1)
        return inside, _solve(self.vertices[inside], faces, int(self._local_index[source]))

    def _candidates(self, source: int, distance: np.ndarray) -> np.ndarray:
        """Vertices that the bound of `closer` cannot rule out, sorted."""
        radius = distance.max()
        if not np.isfinite(radius):
            return np.arange(len(self.vertices))
        ball = self._tree.query_ball_point(self.vertices[source], radius + 2 * self._reach.max())
        ball = np.sort(np.asarray(ball))
        gap = np.linalg.norm(self.vertices[ball] - self.vertices[source], axis=1)
        return ball[gap < distance[ball] + 2 * self._reach[ball]]

    def _submesh(self, source: int, near: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Faces that hang together with `source` and have all corners in `near`.

        Returns
        -------
        vertices : ndarray of int, shape (K,)
        faces : ndarray, shape (F', 3)
            Numbered within `vertices`.
        """
        starts, counts = self._corner_starts[near], np.diff(self._corner_starts)[near]
        first_slots = starts - np.concatenate([[0], np.cumsum(counts)[:-1]])
        slots = np.repeat(first_slots, counts) + np.arange(counts.sum())
        found, hits = np.unique(self._corner_faces[slots], return_counts=True)
        faces = self.faces[self._joined(found[hits == 3], source)]
        inside = np.unique(faces)
        self._local_index[inside] = np.arange(len(inside))
        return inside, self._local_index[faces]

    def _joined(self, candidates: np.ndarray, source: int) -> np.ndarray:
        """Those of some faces that can be reached from a vertex across edges, found ring by ring.

        The solver leaves the distance of whatever it cannot reach undefined.
        """
        waiting = np.zeros(len(self.faces) + 1, dtype=bool)
        waiting[candidates] = True
        ring = candidates[(self.faces[candidates] == source).any(axis=1)]
        rings = []
        while len(ring):
            waiting[ring] = False
            rings.append(ring)
            beyond = self._beyond[ring].ravel()
            ring = self._once(beyond[waiting[beyond]])
        return np.sort(np.concatenate(rings)) if rings else candidates[:0]

    def _once(self, faces: np.ndarray) -> np.ndarray:
        """Each of some faces once: of a few, without the sorting that takes most of a ring's time."""
        places = np.arange(len(faces))
        self._place[faces] = places
        return faces[self._place[faces] == places]


def exact_is_available() -> bool:
    """Whether the library of exact distances is there, which has no wheel for every Python."""
    return find_spec("pygeodesic") is not None


def _solve(vertices: np.ndarray, faces: np.ndarray, source: int) -> np.ndarray:
    """Exact distances of all vertices of a mesh in one piece from one of them."""
    try:
        from pygeodesic.geodesic import PyGeodesicAlgorithmExact
    except ImportError as error:
        raise ImportError(
            'exact geodesics need the package "pygeodesic"; install it or sample with mode="fast"'
        ) from error
    return PyGeodesicAlgorithmExact(vertices, faces).geodesicDistances([source], None)[0]


def _faces_beyond(faces: np.ndarray) -> np.ndarray:
    """Face on the other side of each face's three edges, shape (F, 3); F where there is none."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    order = np.lexsort(edges.T)
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    first, second = order[:-1][same], order[1:][same]
    beyond = np.full(len(edges), len(faces))
    beyond[first], beyond[second] = second % len(faces), first % len(faces)
    return beyond.reshape(3, -1).T


def _longest_edge_at_vertices(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Longest edge of the faces around each vertex, shape (V,)."""
    corners = vertices[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    result = np.zeros(len(vertices))
    for corner in range(3):
        np.maximum.at(result, faces[:, corner], longest)
    return result
