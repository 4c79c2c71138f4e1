# SPDX-License-Identifier: GPL-3.0-or-later
"""Farthest-point sampling: picks cover the body evenly by exact distances, and pairs mirror each other."""

from __future__ import annotations

import numpy as np
import trimesh
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from w2w.core.patches.patches import PATCH_ORDER, farthest_points, mirrored_farthest_points
from w2w.core.patches.strip_graph import StripGraph


def test_every_vertex_may_be_picked() -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    picks = farthest_points(StripGraph.of(ball.vertices, ball.faces), len(ball.vertices), 3)
    assert picks[0] == 3
    assert sorted(picks) == list(range(len(ball.vertices)))


def test_picks_cover_the_body_as_evenly_as_by_exact_distances(bundled_body) -> None:
    body = bundled_body
    picks = farthest_points(StripGraph.of(body.vertices, body.faces), 512, 0)
    exact = PyGeodesicAlgorithmExact(body.vertices, body.faces)
    best = np.load(PATCH_ORDER)[:512]
    widest, least = (exact.geodesicDistances(centres.tolist(), None)[0].max() for centres in (picks, best))
    assert widest < 1.05 * least


def test_mirrored_picks_come_in_pairs_that_keep_their_distance(bundled_body) -> None:
    body = bundled_body
    graph = StripGraph.of(body.vertices, body.faces)
    start = int(np.flatnonzero(body.mirror == np.arange(len(body.mirror)))[0])
    for n in (101, 102):
        picks = mirrored_farthest_points(graph, n, start, body.mirror)
        assert len(set(picks)) == n
        assert set(body.mirror[picks]) == set(picks)
        between = graph.distances(picks)[:, picks]
        np.fill_diagonal(between, np.inf)
        assert between.min() > 0.8 * graph.distances(picks, nearest=True).max()
