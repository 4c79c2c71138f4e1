# SPDX-License-Identifier: GPL-3.0-or-later
"""Farthest-point sampling: picks cover the body evenly by exact distances."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from w2w.core.patches.patches import PATCH_ORDER, farthest_points
from w2w.core.patches.strip_graph import StripGraph


def test_every_vertex_may_be_picked() -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    picks = farthest_points(StripGraph.of(ball.vertices, ball.faces), len(ball.vertices), 3)
    assert picks[0] == 3
    assert sorted(picks) == list(range(len(ball.vertices)))


@pytest.mark.slow
def test_picks_cover_the_body_as_evenly_as_by_exact_distances(bundled_body) -> None:
    body = bundled_body
    picks = farthest_points(StripGraph.of(body.vertices, body.faces), 512, 0)
    exact = PyGeodesicAlgorithmExact(body.vertices, body.faces)
    best = np.load(PATCH_ORDER)[:512]
    widest, least = (exact.geodesicDistances(centres.tolist(), None)[0].max() for centres in (picks, best))
    assert widest < 1.05 * least
