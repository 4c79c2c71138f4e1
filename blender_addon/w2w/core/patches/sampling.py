# SPDX-License-Identifier: GPL-3.0-or-later
"""Farthest-point sampling of a mesh with any way to measure distance along its surface.

Gonzalez (1985, doi:10.1016/0304-3975(85)90224-5); for images, Eldar et al. (1997,
doi:10.1109/83.623193).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

TIE = 1e-9
"""Distances closer than this (metres) count as equal, so that rounding never decides a pick."""


class DistanceSolver(Protocol):
    """What farthest-point sampling asks of a way to measure distance."""

    def closer(self, source: int, distance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and their distance from `source`: all whose distance may lie below `distance`."""
        ...


def farthest_points(solver: DistanceSolver, n: int, start: int, n_vertices: int) -> Sampling:
    """Farthest-point sampling: each pick is the vertex farthest from all earlier ones.

    Vertices within `TIE` of the farthest count as equally far: the
    lowest index is taken.

    Parameters
    ----------
    solver : DistanceSolver
    n : int
        How many points to pick.
    start : int
        The first one.
    n_vertices : int
        Number of vertices of the mesh.
    """
    sampling = Sampling(n_vertices)
    sampling.add(solver, start)
    while len(sampling.picks) < n:
        sampling.add(solver, farthest(sampling.distance))
    return sampling


def mirrored_farthest_points(
    solver: DistanceSolver, n: int, start: int, mirror: np.ndarray, pair_gap: np.ndarray
) -> Sampling:
    """Farthest-point sampling of a mirror-symmetric mesh by mirror pairs.

    Each step takes the vertex, or the pair of mirror images, that is farthest from all earlier
    picks and, for a pair, from each other.

    Parameters
    ----------
    solver : DistanceSolver
    n : int
        How many points to pick.
    start : int
        The first one, or one of the first two.
    mirror : ndarray of int, shape (V,)
        Mirror image of each vertex.
    pair_gap : ndarray, shape (V,)
        Distance of each vertex from its image; inf for those that are their own.
    """
    sampling = Sampling(len(mirror))
    single = np.flatnonzero(mirror == np.arange(len(mirror)))
    pick = start
    while True:
        sampling.add(solver, pick)
        if mirror[pick] != pick and len(sampling.picks) < n:
            sampling.add(solver, int(mirror[pick]))
        left = n - len(sampling.picks)
        if left == 0:
            return sampling
        if left == 1 and len(single):
            pick = int(single[farthest(sampling.distance[single])])
        else:
            pick = farthest(np.minimum(sampling.distance, pair_gap))


class Sampling:
    """Points picked on a mesh so far, and how far every vertex is from them.

    Attributes
    ----------
    picks : list of int
    labels : ndarray, shape (V,)
        Position in `picks` of the nearest one.
    distance : ndarray, shape (V,)
        Distance to it, metres.
    """

    def __init__(self, n_vertices: int) -> None:
        self.picks: list[int] = []
        self.labels = np.zeros(n_vertices, dtype=np.int32)
        self.distance = np.full(n_vertices, np.inf)

    def add(self, solver: DistanceSolver, pick: int) -> None:
        """Pick a vertex and shorten the distances of those that it is nearest to."""
        inside, values = solver.closer(pick, self.distance)
        nearer = values < self.distance[inside] - TIE
        self.labels[inside[nearer]] = len(self.picks)
        self.distance[inside] = np.minimum(self.distance[inside], values)
        self.picks.append(pick)


def farthest(distance: np.ndarray) -> int:
    """Lowest index whose distance is within `TIE` of the largest."""
    return int(np.argmax(distance >= distance.max() - TIE))
