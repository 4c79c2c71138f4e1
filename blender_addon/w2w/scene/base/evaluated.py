# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a mesh's own vertices are after everything that Blender evaluates on it."""

from __future__ import annotations

import bpy
import numpy as np
from scipy.sparse import csr_matrix

from .body import matrix

TAG = "W2W vertex tag"


class EvaluatedVertices:
    """Reads world positions of some vertices of a mesh from its evaluated copy, frame after frame.

    Modifiers that add or remove vertices are followed too: a vertex is found again by a tag
    that modifiers pass on and never make anew, and where they copied it the middle of its
    copies counts, as in Blender's vertex parenting. One that removes a wanted vertex is refused.
    """

    def __init__(self, mesh: bpy.types.Object, vertices: np.ndarray) -> None:
        self.mesh = mesh
        self.vertices = vertices
        self._depsgraph = bpy.context.evaluated_depsgraph_get()
        self._coordinates = np.empty((0, 3), dtype=np.float32)
        self._sources: csr_matrix | None = None

    def positions(self) -> np.ndarray:
        """World positions of the wanted vertices in the scene's current frame, metres, shape (..., 3)."""
        own, world = self._own()
        return own[self.vertices] @ world[:3, :3].T + world[:3, 3]

    def everywhere(self) -> np.ndarray:
        """World positions of all the mesh's own vertices, shape (V, 3); NaN where a modifier removed one."""
        own, world = self._own()
        return own @ world[:3, :3].T + world[:3, 3]

    def _own(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the mesh's own vertices are in its own space, and its matrix to the world."""
        evaluated = self.mesh.evaluated_get(self._depsgraph)
        n_vertices = len(evaluated.data.vertices)
        if n_vertices != len(self._coordinates):
            self._sources = None if n_vertices == len(self.mesh.data.vertices) else self._find_sources()
            evaluated = self.mesh.evaluated_get(self._depsgraph)
            self._coordinates = np.empty((n_vertices, 3), dtype=np.float32)
        evaluated.data.attributes["position"].data.foreach_get("vector", self._coordinates.ravel())
        world = matrix(evaluated.matrix_world)
        if self._sources is None:
            return self._coordinates, world
        own = self._sources @ self._coordinates
        own[np.diff(self._sources.indptr) == 0] = np.nan
        return own, world

    def _find_sources(self) -> csr_matrix:
        """Share of each evaluated vertex in each vertex of the mesh, shape (V, evaluated)."""
        tags = _tags(len(self.mesh.data.vertices))
        found = self._evaluated_tags(tags)
        order = np.argsort(tags[:, 0])
        places = np.searchsorted(tags[order, 0], found[:, 0])
        owners = order[np.minimum(places, len(order) - 1)]
        columns = np.flatnonzero((tags[owners] == found).all(axis=1))
        copies = np.bincount(owners[columns], minlength=len(tags))
        lost = np.setdiff1d(self.vertices, np.flatnonzero(copies))
        if len(lost):
            raise ValueError(
                f"the modifiers of '{self.mesh.name}' remove {len(lost)} of the vertices under patches: "
                "switch off the one that does so in the viewport"
            )
        rows = owners[columns]
        return csr_matrix((1 / copies[rows], (rows, columns)), shape=(len(tags), len(found)))

    def _evaluated_tags(self, tags: np.ndarray) -> np.ndarray:
        attributes = self.mesh.data.attributes
        attributes.new(TAG, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", tags.ravel())
        try:
            self._depsgraph.update()
            evaluated = self.mesh.evaluated_get(self._depsgraph).data
            values = np.zeros((len(evaluated.vertices), 3), dtype=np.float32)
            if TAG in evaluated.attributes:
                evaluated.attributes[TAG].data.foreach_get("vector", values.ravel())
        finally:
            attributes.remove(attributes[TAG])
            self._depsgraph.update()
        return values


def _tags(n_vertices: int) -> np.ndarray:
    """Vectors of which none is a mean of others, the first components distinct, shape (V, 3)."""
    generator = np.random.default_rng(0)
    tags = generator.random((n_vertices, 3), dtype=np.float32)
    tags[:, 0] = (generator.permutation(n_vertices) + 1) / (n_vertices + 1)
    return tags
