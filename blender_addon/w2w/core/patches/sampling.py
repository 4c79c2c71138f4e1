# SPDX-License-Identifier: GPL-3.0-or-later
"""Farthest-point sampling of a mesh by distances along its surface.

Gonzalez (1985, doi:10.1016/0304-3975(85)90224-5); for images, Eldar et al. (1997,
doi:10.1109/83.623193).
"""

from __future__ import annotations

import numpy as np

from .strip_graph import StripGraph

TIE = 1e-9
"""Distances closer than this (metres) count as equal, so that rounding never decides a pick."""


def farthest_points(graph: StripGraph, n: int, start: int) -> np.ndarray:
    """Pick `n` vertices, each the farthest from all earlier ones, beginning at `start`."""
    picks, distance = [start], graph.distances(start)
    while len(picks) < n:
        picks.append(farthest(distance))
        distance = np.minimum(distance, graph.distances(picks[-1], limit=distance.max()))
    return np.array(picks)


def mirrored_farthest_points(graph: StripGraph, n: int, start: int, mirror: np.ndarray) -> np.ndarray:
    """Farthest-point sampling of a mirror-symmetric mesh by mirror pairs.

    Each step takes the vertex, or the pair of mirror images, that is farthest from all earlier
    picks and, for a pair, from each other.

    Parameters
    ----------
    graph : StripGraph
    n : int
        How many points to pick.
    start : int
        The first one, on the mirror plane.
    mirror : ndarray of int, shape (V,)
        Mirror image of each vertex.
    """
    on_plane = np.flatnonzero(mirror == np.arange(len(mirror)))
    # a shortest way to the image crosses the plane halfway
    pair_gap = 2 * graph.distances(on_plane, nearest=True)
    pair_gap[on_plane] = np.inf
    picks, distance = [start], graph.distances(start)
    while len(picks) < n:
        if n - len(picks) == 1:
            pick = int(on_plane[farthest(distance[on_plane])])
        else:
            pick = farthest(np.minimum(distance, pair_gap))
        for one in dict.fromkeys((pick, int(mirror[pick]))):
            picks.append(one)
            distance = np.minimum(distance, graph.distances(one, limit=distance.max()))
    return np.array(picks)


def farthest(distance: np.ndarray) -> int:
    """Lowest index whose distance is within `TIE` of the largest."""
    return int(np.argmax(distance >= distance.max() - TIE))
