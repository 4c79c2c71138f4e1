# SPDX-License-Identifier: GPL-3.0-or-later
"""One half of the body remeshed to exactly 6,888 triangles."""

from __future__ import annotations

import numpy as np
import pymeshlab

HALF_FACES = 6888


def remesh_half(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quadric decimation (Garland and Heckbert 1997) to 6,888 faces.

    Parameters
    ----------
    vertices, faces : ndarray
        The half on x >= 0; its boundary lies on x = 0.

    Returns
    -------
    vertices : ndarray, shape (V, 3)
        Vertices of the boundary lie on x = 0 exactly.
    faces : ndarray, shape (6888, 3)
    """
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_decimation_quadric_edge_collapse(
        targetfacenum=HALF_FACES,
        preserveboundary=True,
        boundaryweight=1,
        qualitythr=0.8,
        preservenormal=True,
        planarquadric=True,
        planarweight=0.01,
        autoclean=False,
        preservetopology=True,
    )
    mesh = meshes.current_mesh()
    vertices, faces = mesh.vertex_matrix().copy(), mesh.face_matrix().astype(int)
    vertices[boundary_vertices(faces), 0] = 0
    return vertices, faces


def boundary_vertices(faces: np.ndarray) -> np.ndarray:
    """Vertices on edges that only one face has."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    return np.unique(unique[counts == 1])
