# SPDX-License-Identifier: GPL-3.0-or-later
"""Which three vertices carry a patch: a triangle whose frame is steady when the body moves.

A frame on a sliver turns float noise into rotation noise, and a triangle across a joint turns with
neither bone. So the carrier of a patch is chosen among all triples of vertices near its centre:
tall enough, near equilateral, facing outward and made of vertices that share their bones.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from .body import Body
from .geodesics import StripGraph

NEIGHBOURS = 14
"""Vertices nearest to a patch's centre that may carry it: all triples of them are tried."""

MIN_HEIGHT = 0.004
"""Least height of a carrier triangle, metres."""

CHUNK = 256


def carrier_triangles(body: Body, graph: StripGraph, centres: np.ndarray) -> np.ndarray:
    """The triangle that carries each patch.

    Parameters
    ----------
    body : Body
    graph : StripGraph
    centres : ndarray of int, shape (N,)

    Returns
    -------
    ndarray, shape (N, 3), int32
        v1, v2, v3 as in Blender's three-vertex parent: x along v2 - v1, z outward.
    """
    triples = np.array(list(combinations(range(NEIGHBOURS), 3)))
    chosen = np.empty((len(centres), 3), dtype=np.int32)
    for patch, near in enumerate(nearest_vertices(graph, centres, NEIGHBOURS)):
        candidates = near[triples]
        cost, flipped = _cost(body, int(centres[patch]), candidates)
        best = int(np.argmin(cost))
        first, second, third = candidates[best]
        chosen[patch] = (first, third, second) if flipped[best] else (first, second, third)
    return chosen


def nearest_vertices(graph: StripGraph, centres: np.ndarray, count: int) -> np.ndarray:
    """The vertices nearest to each centre along the surface, itself first, shape (N, count)."""
    near = np.empty((len(centres), count), dtype=np.int64)
    for begin in range(0, len(centres), CHUNK):
        distance = graph.distances(centres[begin : begin + CHUNK])
        near[begin : begin + CHUNK] = np.argsort(distance, axis=1, kind="stable")[:, :count]
    return near


def _cost(body: Body, centre: int, candidates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How bad each triple is as a carrier, and whether its order must be turned to face outward."""
    corners = body.vertices[candidates]
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(edges, axis=2)
    normal = np.cross(edges[:, 0], -edges[:, 2])
    double_area = np.linalg.norm(normal, axis=1)
    height = double_area / lengths.max(axis=1)
    outward = normal @ body.vertex_normals[centre] / np.maximum(double_area, np.finfo(float).tiny)
    shape = 2 * np.sqrt(3) * double_area / (lengths**2).sum(axis=1)
    size = lengths.mean(axis=1)
    offset = np.linalg.norm(corners.mean(axis=1) - body.vertices[centre], axis=1)
    weights = body.weights[candidates]
    spread = np.abs(weights - weights.mean(axis=1, keepdims=True)).sum(axis=2).max(axis=1)
    steepness = spread / size * MIN_HEIGHT * 5
    cost = 2 * (1 - shape) + 2 * (1 - np.abs(outward)) + 30 * offset + 4 * steepness
    return cost + 100 * (height < MIN_HEIGHT) * (1 - height / MIN_HEIGHT), outward < 0
