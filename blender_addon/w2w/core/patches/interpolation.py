# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches spread over the vertices: smooth, along the surface, never outside their range."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from .strip_graph import StripGraph

REACH = 2.2
"""Support of a patch's kernel, in units of the largest distance of a vertex from its patch."""

SHARPNESS = 0.3
"""Distance, in the same unit, within which a patch's own score shows almost alone."""

CHUNK = 256


def interpolation_weights(graph: StripGraph, centres: np.ndarray) -> csr_matrix:
    """Share of each patch in the value shown at each vertex.

    Inverse squared distance to the patch centres under a compact kernel (after Franke and Nielson
    1980, doi:10.1002/nme.1620151110; Wendland's C2, 1995, doi:10.1007/BF02123482), normalised at
    every vertex: at its centre a patch shows its own score, so that no peak is dulled. Distance
    runs along the surface, so nothing bleeds from a wrist to the hip it hangs beside.

    Parameters
    ----------
    graph : StripGraph
    centres : ndarray of int, shape (N,)

    Returns
    -------
    csr_matrix, shape (V, N), float32
        Non-negative rows that sum to 1.
    """
    cover = graph.distances(centres, nearest=True)
    reach = REACH * float(cover[np.isfinite(cover)].max())
    rows, columns, values = [], [], []
    for begin in range(0, len(centres), CHUNK):
        distance = graph.distances(centres[begin : begin + CHUNK], limit=reach)
        column, row = np.nonzero(distance < reach)
        scaled = distance[column, row] / reach
        rows.append(row)
        columns.append(column + begin)
        near = (REACH * scaled) ** 2 + SHARPNESS**2
        values.append((1 - scaled) ** 4 * (4 * scaled + 1) / near)
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    weights = csr_matrix(entries, shape=(len(cover), len(centres)))
    total = np.asarray(weights.sum(axis=1))
    return weights.multiply(1 / total).tocsr().astype(np.float32)
