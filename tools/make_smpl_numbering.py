# SPDX-License-Identifier: GPL-3.0-or-later
"""How `assets/templates/smpl_numbering.npz` and its digests follow from the faces of SMPL-Body."""

from __future__ import annotations

import numpy as np

from w2w.core.adopt.topology import N_VERTICES, canonical_walk, walk_digest


def describe_topology(triangles: np.ndarray, quads: np.ndarray) -> tuple[dict[str, np.ndarray], str, str]:
    """What `NUMBERING` and the two digests hold, from SMPL's faces.

    Parameters
    ----------
    triangles : ndarray, shape (13776, 3)
        In SMPL's numbering and winding.
    quads : ndarray, shape (6900, 4)
        The same mesh before its quads were cut, -1 in the fourth column of triangles.

    Returns
    -------
    arrays : dict of str to ndarray
    triangles_sha256, quads_sha256 : str
    """
    walk = canonical_walk([tuple(face) for face in triangles.tolist()], N_VERTICES)
    polygons = [tuple(corner for corner in face if corner >= 0) for face in quads.tolist()]
    quad_walk = canonical_walk(polygons, N_VERTICES)
    joined = {(face[k], face[k - 1]) for face in triangles.tolist() for k in range(3)}
    cut = [(face[0], face[2]) in joined for face in quad_walk.corners if len(face) == 4]
    arrays = {"smpl_vertex": walk.vertices.astype(np.uint16), "cut": np.packbits(cut)}
    return arrays, walk_digest(walk, N_VERTICES), walk_digest(quad_walk, N_VERTICES)
