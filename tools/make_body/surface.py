# SPDX-License-Identifier: GPL-3.0-or-later
"""The source surface that the remesher keeps to: closest points, its mirror seam, its curved form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np

from w2w.core.body.body import vertex_normals

MIN_FACING = 0.3
"""Cosine below which a closest point is taken to lie on another sheet (the next finger, the other lip)."""

ROUNDING = 0.75
"""Strength of the rounding towards the vertices' tangent planes (Boubekeur and Alexa 2008 use 3/4)."""

MAX_ROUNDING = 0.0008
"""Rounding never moves a point farther than this, metres."""


@dataclass(frozen=True)
class Surface:
    """The left half of the source body with a wanted edge length at every vertex.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray, shape (F, 3)
    lengths : ndarray, shape (V,)
        Wanted edge lengths, metres.
    """

    vertices: np.ndarray
    faces: np.ndarray
    lengths: np.ndarray

    @cached_property
    def seam(self) -> np.ndarray:
        """Edges (E, 2) of the boundary, in the mirror plane."""
        return boundary_edges(self.faces)

    @cached_property
    def face_normals(self) -> np.ndarray:
        """Unit normals, shape (F, 3)."""
        corners = self.vertices[self.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """Unit normals, shape (V, 3), in the mirror plane along the seam."""
        normals = vertex_normals(self.vertices, self.faces)
        normals[np.unique(self.seam), 0] = 0
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Closest points (N, 3), the faces (N,) they lie on and their barycentric coordinates (N, 3)."""
        _, index, closest = igl.point_mesh_squared_distance(points, self.vertices, self.faces)
        index = index.ravel()
        return closest, index, self._coordinates(closest, index)

    def closest_facing(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, ...]:
        """Like `closest`, among the faces that look the way `normals` (N, 3) do."""
        closest, index, _ = self.closest(points)
        away = np.einsum("na,na->n", self.face_normals[index], normals) < MIN_FACING
        for point in np.flatnonzero(away):
            facing = np.flatnonzero(self.face_normals @ normals[point] >= MIN_FACING)
            _, found, nearest = igl.point_mesh_squared_distance(
                points[point : point + 1], self.vertices, self.faces[facing]
            )
            index[point], closest[point] = facing[found.ravel()[0]], nearest[0]
        return closest, index, self._coordinates(closest, index)

    def closest_on_seam(self, points: np.ndarray) -> np.ndarray:
        """Closest points on the boundary of the surface, x = 0 exactly."""
        closest = igl.point_mesh_squared_distance(points, self.vertices, self.seam)[2]
        closest[:, 0] = 0
        return closest

    def lengths_at(self, points: np.ndarray) -> np.ndarray:
        """Wanted edge lengths at points near the surface, metres."""
        _, index, coordinates = self.closest(points)
        return np.einsum("nk,nk->n", self.lengths[self.faces[index]], coordinates)

    def rounded(self, points: np.ndarray, index: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        """Points of the flat faces moved onto a rounded surface through the same vertices.

        Phong tessellation (Boubekeur and Alexa 2008, doi:10.1145/1409060.1409094), so that
        the flats of the coarse source do not show.
        """
        corners, normals = self.vertices[self.faces[index]], self.vertex_normals[self.faces[index]]
        heights = np.einsum("nka,nka->nk", points[:, None] - corners, normals)
        move = -ROUNDING * np.einsum("nk,nk,nka->na", coordinates, heights, normals)
        length = np.linalg.norm(move, axis=1, keepdims=True)
        return points + move * np.minimum(1, MAX_ROUNDING / np.maximum(length, 1e-12))

    def _coordinates(self, points: np.ndarray, index: np.ndarray) -> np.ndarray:
        """Barycentric coordinates in given faces, clipped into them."""
        corners = (np.ascontiguousarray(self.vertices[self.faces[index, corner]]) for corner in range(3))
        coordinates = igl.barycentric_coordinates(points, *corners)
        coordinates = np.nan_to_num(np.clip(coordinates, 0, 1), nan=1 / 3)
        return coordinates / coordinates.sum(axis=1, keepdims=True)


def boundary_edges(faces: np.ndarray) -> np.ndarray:
    """Edges that only one face has, shape (E, 2)."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    return unique[counts == 1]
