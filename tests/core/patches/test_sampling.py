# SPDX-License-Identifier: GPL-3.0-or-later
"""Farthest-point sampling: every pick is the farthest vertex, by distances computed the slow way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from w2w.core.patches.geodesics import ExactSolver
from w2w.core.patches.sampling import Sampling, farthest_points, mirrored_farthest_points
from w2w.core.patches.strip_graph import StripGraph


def assert_each_pick_is_farthest(vertices: np.ndarray, faces: np.ndarray, sampling: Sampling) -> None:
    """Check every pick, label and distance against full exact propagations."""
    brute = PyGeodesicAlgorithmExact(vertices, faces)
    distances = [brute.geodesicDistances([sampling.picks[0]], None)[0]]
    for pick in sampling.picks[1:]:
        nearest = np.min(distances, axis=0)
        assert nearest[pick] >= nearest.max() - 2e-9
        distances.append(brute.geodesicDistances([pick], None)[0])
    np.testing.assert_allclose(sampling.distance, np.min(distances, axis=0), atol=1e-9)
    own = np.array(distances)[sampling.labels, np.arange(len(vertices))]
    np.testing.assert_allclose(own, sampling.distance, atol=1e-8)


def exact_sampling(vertices: np.ndarray, faces: np.ndarray, n: int, start: int) -> Sampling:
    return farthest_points(ExactSolver(vertices, faces), n, start, len(vertices))


def test_picks_are_farthest_on_the_bundled_body(bundled_body) -> None:
    sampling = exact_sampling(bundled_body.vertices, bundled_body.faces, 24, start=1234)
    assert_each_pick_is_farthest(bundled_body.vertices, bundled_body.faces, sampling)


@pytest.mark.parametrize("name", ["human_man.obj", "human_woman.obj"])
def test_picks_are_farthest_on_other_bodies(shared_data: Path, name: str) -> None:
    mesh = trimesh.load(shared_data / "smpl_body" / name, process=False, maintain_order=True)
    sampling = exact_sampling(mesh.vertices, mesh.faces, 14, start=17)
    assert_each_pick_is_farthest(mesh.vertices, mesh.faces, sampling)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_picks_are_farthest_on_any_blob(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices = ball.vertices * rng.uniform(0.4, 1.6, size=(len(ball.vertices), 1)) * rng.uniform(0.3, 1, 3)
    n = int(rng.integers(2, 40))
    sampling = exact_sampling(vertices, ball.faces, n, start=int(rng.integers(len(vertices))))
    assert_each_pick_is_farthest(vertices, ball.faces, sampling)


def test_512_picks_agree_with_propagation_from_all_of_them_at_once(bundled_body) -> None:
    """No cell is cut out here: one propagation over the whole mesh from all earlier picks."""
    body = bundled_body
    sampling = exact_sampling(body.vertices, body.faces, 512, start=0)
    brute = PyGeodesicAlgorithmExact(body.vertices, body.faces)
    for count in (1, 2, 5, 17, 64, 150, 256, 400, 511):
        nearest, _ = brute.geodesicDistances(sampling.picks[:count], None)
        assert nearest[sampling.picks[count]] >= nearest.max() - 2e-9
    nearest, _ = brute.geodesicDistances(sampling.picks, None)
    np.testing.assert_allclose(sampling.distance, nearest, atol=1e-9)


def test_every_vertex_may_be_picked() -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    sampling = exact_sampling(ball.vertices, ball.faces, len(ball.vertices), start=3)
    assert sorted(sampling.picks) == list(range(len(ball.vertices)))
    assert (sampling.distance == 0).all()


def test_fast_picks_cover_the_body_as_evenly_as_exact_ones(bundled_body) -> None:
    body = bundled_body
    exact = exact_sampling(body.vertices, body.faces, 512, start=0)
    solver = ExactSolver(body.vertices, body.faces)
    fast = farthest_points(StripGraph.of(body.vertices, body.faces), 512, 0, len(body.vertices))
    checked = Sampling(len(body.vertices))
    for pick in fast.picks:
        checked.add(solver, pick)
    assert checked.distance.max() < 1.05 * exact.distance.max()
    # the fast distances themselves err by well under those of the heat method (1.1 %)
    away = checked.distance > 0
    error = fast.distance[away] / checked.distance[away] - 1
    assert error.min() > -1e-7
    assert error.mean() < 0.006


def test_mirrored_picks_come_in_pairs_that_keep_their_distance(bundled_body) -> None:
    body = bundled_body
    graph = StripGraph.of(body.vertices, body.faces)
    on_plane = np.flatnonzero(body.mirror == np.arange(len(body.mirror)))
    gap = 2 * graph.distances(on_plane, nearest=True)
    gap[on_plane] = np.inf
    for n in (101, 102):
        sampling = mirrored_farthest_points(graph, n, int(on_plane[0]), body.mirror, gap)
        assert len(set(sampling.picks)) == n
        assert set(body.mirror[sampling.picks]) == set(sampling.picks)
        between = graph.distances(np.array(sampling.picks))[:, sampling.picks]
        np.fill_diagonal(between, np.inf)
        assert between.min() > 0.8 * sampling.distance.max()
