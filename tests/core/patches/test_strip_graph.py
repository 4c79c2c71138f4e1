# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearly exact geodesic distances against analytic truth and exact ones."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings, strategies as st
from pygeodesic.geodesic import PyGeodesicAlgorithmExact
from scipy.spatial import Delaunay

from w2w.core.patches.strip_graph import StripGraph


def flat_disc(seed: int, n: int = 150) -> tuple[np.ndarray, np.ndarray]:
    """A convex flat mesh of random points, where geodesics are straight."""
    points = np.random.default_rng(seed).uniform(-1, 1, size=(n, 2))
    return np.c_[points, np.zeros(n)], Delaunay(points).simplices


def exact_distances(body, source: int) -> np.ndarray:
    """By pygeodesic, after Mitchell, Mount and Papadimitriou (1987)."""
    return PyGeodesicAlgorithmExact(body.vertices, body.faces).geodesicDistances([source], None)[0]


def test_distance_to_another_piece_is_infinite() -> None:
    one = trimesh.creation.icosphere(subdivisions=1)
    two = one.copy()
    two.apply_translation((5, 0, 0))
    both = trimesh.util.concatenate(one, two)
    distance = StripGraph.of(both.vertices, both.faces).distances(0)
    assert np.isfinite(distance[: len(one.vertices)]).all()
    assert np.isinf(distance[len(one.vertices) :]).all()
    assert StripGraph.of(both.vertices, both.faces).n_pieces == 2


@pytest.mark.slow
def test_strip_graph_is_never_below_the_exact_distance_and_close_to_it(bundled_body) -> None:
    body = bundled_body
    graph = StripGraph.of(body.vertices, body.faces)
    sources = np.random.default_rng(0).integers(len(body.vertices), size=6)
    exact = np.array([exact_distances(body, int(s)) for s in sources])
    near = graph.distances(sources)
    away = exact > 0
    error = (near[away] - exact[away]) / exact[away]
    assert error.min() > -1e-7
    # the heat method errs by 1.1 % on average and 4.6 % at the 99th percentile
    assert error.mean() < 0.008
    assert np.percentile(error, 99) < 0.025


@pytest.mark.slow
def test_more_crossings_bring_the_graph_closer_to_the_exact_distance(bundled_body) -> None:
    body = bundled_body
    exact = exact_distances(body, 100)
    away = exact > 0
    errors = []
    for crossings in (0, 1, 3):
        near = StripGraph.of(body.vertices, body.faces, crossings).distances(100)
        errors.append(((near[away] - exact[away]) / exact[away]).mean())
    assert errors[0] > 2 * errors[1] > 4 * errors[2] > 0


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_lines_over_flat_strips_have_their_straight_length(seed: int) -> None:
    vertices, faces = flat_disc(seed, n=60)
    lines = StripGraph.of(vertices, faces).graph.tocoo()
    straight = np.linalg.norm(vertices[lines.row] - vertices[lines.col], axis=1)
    np.testing.assert_allclose(lines.data, straight, rtol=1e-7, atol=1e-9)
    assert abs(lines - lines.T).max() < 1e-12


def test_strip_graph_joins_vertices_across_a_fold_by_the_unfolded_line() -> None:
    # two unit right triangles hinged at the y axis, folded to any angle: unfolded, they are 2 apart
    for angle in np.radians([20, 90, 160]):
        vertices = np.array([[-1, 0, 0], [0, -1, 0], [0, 1, 0], [np.cos(angle), 0, np.sin(angle)]])
        graph = StripGraph.of(vertices, np.array([[0, 1, 2], [1, 3, 2]]))
        assert graph.distances(0)[3] == pytest.approx(2)


@pytest.mark.later
def test_neighbourhoods_are_nearest_first_and_large_enough(bundled_body) -> None:
    body = bundled_body
    graph = StripGraph.of(body.vertices, body.faces)
    centres = np.array([0, 3000, 6000])
    for centre, near in zip(centres, graph.neighbourhoods(centres, 0.002, 16), strict=True):
        distance = graph.distances(int(centre))
        assert near[0] == centre
        assert len(near) == 16
        assert (np.diff(distance[near]) >= 0).all()
        assert distance[near[-1]] <= np.sort(distance)[15]
