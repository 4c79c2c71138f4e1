# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches spread over the vertices: smooth, along the surface, never outside their range."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from .strip_graph import StripGraph

REACH = 2.0
"""Support of a patch's kernel, in units of the largest distance of a vertex from its patch."""

CHUNK = 256


def interpolation_weights(graph: StripGraph, centres: np.ndarray) -> csr_matrix:
    """Share of each patch in the value shown at each vertex.

    Wendland's C2 kernel (1995, doi:10.1007/BF02123482) of the geodesic distance to the patch
    centres, normalised at every vertex. Distance runs along the surface, so nothing bleeds
    from a wrist to the hip it hangs beside.

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
        values.append((1 - scaled) ** 4 * (4 * scaled + 1))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    weights = csr_matrix(entries, shape=(len(cover), len(centres)))
    total = np.asarray(weights.sum(axis=1))
    return weights.multiply(1 / total).tocsr().astype(np.float32)
