# SPDX-License-Identifier: GPL-3.0-or-later
"""Skinning weights of the remeshed body: smooth, sharp enough to keep the volume, at most four a vertex."""

from __future__ import annotations

import igl
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

SPREAD = 0.02
"""Weights are diffused over about this distance along the surface, metres."""

SHARPENING = 1.5
"""Exponent on the weights: narrower bends, so that a hip at 90 degrees loses less volume."""

MAX_WEIGHTS = 4
SMALLEST_WEIGHT = 1e-3

TIE = 1e-6
"""Weights this near in proportion count as equal, so that on the mirror plane left and right go together."""


def smooth_weights(vertices: np.ndarray, faces: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Diffuse, sharpen and thin out weights.

    One implicit step of heat flow on the surface, (M + t L) w' = M w with t = SPREAD^2 / 2,
    spreads them evenly whatever the density of the mesh; the result stays between 0 and 1.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray, shape (F, 3)
    weights : ndarray, shape (V, 24)

    Returns
    -------
    ndarray, shape (V, 24)
        Rows sum to 1 and have at most four entries that are not zero.
    """
    mass = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI)
    stiffness = -igl.cotmatrix(vertices, faces)
    system = splu(sparse.csc_matrix(mass + SPREAD**2 / 2 * stiffness))
    diffused = np.clip(system.solve(mass @ weights), 0, 1) ** SHARPENING
    too_many = np.partition(diffused, -MAX_WEIGHTS - 1, axis=1)[:, [-MAX_WEIGHTS - 1]]
    thinned = np.where(diffused > too_many * (1 + TIE), diffused, 0)
    thinned /= thinned.sum(axis=1, keepdims=True)
    thinned[thinned < SMALLEST_WEIGHT] = 0
    return thinned / thinned.sum(axis=1, keepdims=True)
