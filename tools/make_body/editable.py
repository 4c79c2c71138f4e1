# SPDX-License-Identifier: GPL-3.0-or-later
"""A triangle mesh with a boundary whose edges can be split, collapsed and flipped.

The mesh is one half of a mirror-symmetric body: its boundary lies in the mirror plane, so
an inner edge may never join two boundary vertices (mirrored, it would be there twice).
"""

from __future__ import annotations

import numpy as np

Point = tuple[float, float, float]
Triangle = tuple[int, int, int]

MAX_VALENCE = 8
MIN_NORMAL_AGREEMENT = 0.7
"""Smallest cosine between a triangle's normal before and after an operation."""


class EditableMesh:
    """Triangles that know their vertices and vertices that know their triangles.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray, shape (F, 3)
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.points: list[Point] = [tuple(point) for point in vertices.tolist()]
        self.triangles: dict[int, Triangle] = {}
        self.around: list[set[int]] = [set() for _ in self.points]
        self.on_boundary = [False] * len(self.points)
        self._next_triangle = 0
        for face in faces.tolist():
            self._add(*face)
        edges, counts = self.edges()
        for vertex in np.unique(edges[counts == 1]):
            self.on_boundary[vertex] = True

    def faces(self) -> np.ndarray:
        """Triangles as an array, shape (F, 3), in the order of their making."""
        return np.array(list(self.triangles.values()))

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Unique edges (E, 2), smaller index first, and how many triangles have each."""
        faces = self.faces()
        pairs = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        return np.unique(pairs, axis=0, return_counts=True)

    def compact(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and faces without the vertices that no triangle uses."""
        used, faces = np.unique(self.faces(), return_inverse=True)
        return np.array(self.points)[used], faces.reshape(-1, 3)

    def neighbours(self, vertex: int) -> set[int]:
        """Vertices joined to a vertex by an edge."""
        found = {other for index in self.around[vertex] for other in self.triangles[index]}
        found.discard(vertex)
        return found

    def _triangles_of(self, a: int, b: int) -> list[int]:
        return sorted(self.around[a] & self.around[b])

    def _third(self, index: int, a: int, b: int) -> int:
        return next(vertex for vertex in self.triangles[index] if vertex not in (a, b))

    def full_valence(self, vertex: int, n_neighbours: int) -> int:
        """Valence in the whole body of a vertex with so many neighbours in this half."""
        return 2 * n_neighbours - 2 if self.on_boundary[vertex] else n_neighbours

    def split(self, a: int, b: int) -> int:
        """Put a vertex in the middle of an edge; returns its index."""
        shared = self._triangles_of(a, b)
        middle = len(self.points)
        self.points.append(_middle(self.points[a], self.points[b]))
        self.around.append(set())
        self.on_boundary.append(len(shared) == 1)
        for index in shared:
            triangle = self.triangles[index]
            self._remove(index)
            self._add(*(middle if vertex == b else vertex for vertex in triangle))
            self._add(*(middle if vertex == a else vertex for vertex in triangle))
        return middle

    def collapse(self, a: int, b: int, longest: float) -> bool:
        """Merge an edge's ends, unless that would fold, tangle or stretch the mesh.

        Parameters
        ----------
        a, b : int
        longest : float
            No edge longer than this may come of it, metres.

        Returns
        -------
        bool
            Whether it was done.
        """
        if self.on_boundary[a] and not self.on_boundary[b]:
            a, b = b, a
        shared = self._triangles_of(a, b)
        both = self.on_boundary[a] and self.on_boundary[b]
        if not shared or (both and len(shared) == 2):
            return False
        near_a, near_b = self.neighbours(a), self.neighbours(b)
        if len(near_a & near_b) != len(shared):
            return False
        stays = self.on_boundary[b] and not both
        target = self.points[b] if stays else _middle(self.points[a], self.points[b])
        around = (near_a | near_b) - {a, b}
        if not self._collapse_keeps_shape(a, b, shared, around, target, longest):
            return False
        self._merge(a, b, shared, target)
        return True

    def _collapse_keeps_shape(
        self, a: int, b: int, shared: list[int], around: set[int], target: Point, longest: float
    ) -> bool:
        if self.full_valence(b, len(around)) > MAX_VALENCE:
            return False
        opposite = {self._third(index, a, b) for index in shared}
        for vertex in opposite:
            valence = len(self.neighbours(vertex)) - 1
            if valence < (3 if self.on_boundary[vertex] else 4):
                return False
        if self.on_boundary[b]:
            boundary_links = sum(self.on_boundary[vertex] for vertex in around)
            if boundary_links > 2:
                return False
        if any(_distance(self.points[vertex], target) > longest for vertex in around):
            return False
        moved = (self.around[a] | self.around[b]) - set(shared)
        return all(self._survives(index, {a: target, b: target}) for index in moved)

    def _survives(self, index: int, moved: dict[int, Point]) -> bool:
        triangle = self.triangles[index]
        before = _normal(*(self.points[vertex] for vertex in triangle))
        after = _normal(*(moved.get(vertex, self.points[vertex]) for vertex in triangle))
        return _agree(before, after)

    def _merge(self, a: int, b: int, shared: list[int], target: Point) -> None:
        for index in shared:
            self._remove(index)
        for index in sorted(self.around[a]):
            triangle = self.triangles[index]
            self._remove(index)
            self._add(*(b if vertex == a else vertex for vertex in triangle))
        self.points[b] = target

    def flip_ends(self, a: int, b: int) -> tuple[int, int] | None:
        """The two vertices that a flipped edge would join, or None where it may not be flipped."""
        shared = self._triangles_of(a, b)
        if len(shared) != 2:
            return None
        c, d = (self._third(index, a, b) for index in shared)
        if (self.on_boundary[c] and self.on_boundary[d]) or self.around[c] & self.around[d]:
            return None
        for vertex in (a, b):
            if len(self.neighbours(vertex)) <= (3 if self.on_boundary[vertex] else 4):
                return None
        return c, d

    def flip(self, a: int, b: int) -> bool:
        """Turn an edge to join the two opposite vertices, unless the surface would bend by it."""
        ends = self.flip_ends(a, b)
        if ends is None:
            return False
        first, second = self._triangles_of(a, b)
        c, d = ends
        triangle = self.triangles[first]
        if triangle[(triangle.index(a) + 1) % 3] != b:
            a, b = b, a
        pa, pb, pc, pd = (self.points[vertex] for vertex in (a, b, c, d))
        old = _normal(pa, pb, pc), _normal(pb, pa, pd)
        new = _normal(pa, pd, pc), _normal(pd, pb, pc)
        if not all(_agree(one, other) for one in old for other in new):
            return False
        self._remove(first)
        self._remove(second)
        self._add(a, d, c)
        self._add(d, b, c)
        return True

    def _add(self, a: int, b: int, c: int) -> None:
        index = self._next_triangle
        self._next_triangle += 1
        self.triangles[index] = (a, b, c)
        for vertex in (a, b, c):
            self.around[vertex].add(index)

    def _remove(self, index: int) -> None:
        for vertex in self.triangles.pop(index):
            self.around[vertex].discard(index)


def _middle(p: Point, q: Point) -> Point:
    return (p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2


def _distance(p: Point, q: Point) -> float:
    return ((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2) ** 0.5


def _normal(p: Point, q: Point, r: Point) -> Point:
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


def _agree(n: Point, m: Point) -> bool:
    dot = n[0] * m[0] + n[1] * m[1] + n[2] * m[2]
    lengths = ((n[0] ** 2 + n[1] ** 2 + n[2] ** 2) * (m[0] ** 2 + m[1] ** 2 + m[2] ** 2)) ** 0.5
    return dot > MIN_NORMAL_AGREEMENT * lengths
