# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches on a body: sampling, names, files and scores spread over the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from w2w.core.body.body import Body
from w2w.core.body.shapes import shaped
from w2w.core.patches.patches import PATCH_ORDER, PatchSet, interpolation_weights, sample_patches
from w2w.core.patches.strip_graph import StripGraph

pytestmark = pytest.mark.later

FIRST = [5860, 1404, 4806, 637, 1163, 5521, 6067, 3372]


def test_patches_are_distinct_places_with_a_cell_each(bundled_body, patches) -> None:
    assert len(patches) == 512
    assert len(set(patches.vertices.tolist())) == 512
    assert patches.vertices.dtype == patches.triangles.dtype == patches.labels.dtype == np.int32
    assert patches.labels.shape == (len(bundled_body.vertices),)
    np.testing.assert_array_equal(patches.labels[patches.vertices], np.arange(512))


def test_cells_hold_the_vertices_nearest_to_their_patch(bundled_body, patches) -> None:
    graph = StripGraph.of(bundled_body.vertices, bundled_body.faces)
    for patch in (0, 400):
        cell = np.flatnonzero(patches.labels == patch)
        own = graph.distances(int(patches.vertices[patch]))[cell]
        for other in np.random.default_rng(patch).integers(512, size=3):
            to_other = graph.distances(int(patches.vertices[other]))[cell]
            assert (own <= to_other + 1e-8).all()


def test_the_seed_chooses_the_first_patch(bundled_body) -> None:
    firsts = {int(sample_patches(bundled_body, 3, seed).vertices[0]) for seed in range(5)}
    assert len(firsts) == 5
    one, two = (sample_patches(bundled_body, 20, 7) for _ in range(2))
    np.testing.assert_array_equal(one.triangles, two.triangles)


@pytest.mark.slow
def test_2048_patches_work(bundled_body) -> None:
    patches = sample_patches(bundled_body, 2048)
    assert len(set(patches.vertices.tolist())) == 2048
    spread = patches.to_vertices(np.arange(2048.0))
    assert 0 <= spread.min() < spread.max() <= 2047


@pytest.mark.slow
def test_the_bundled_body_s_patches_are_nested_and_those_of_its_shapes(bundled_body, patches) -> None:
    few, woman = sample_patches(bundled_body, 24), sample_patches(shaped(bundled_body, gender=-1), 512)
    np.testing.assert_array_equal(few.vertices, patches.vertices[:24])
    np.testing.assert_array_equal(woman.vertices, patches.vertices)


def test_the_order_of_the_bundled_body_s_patches_is_fixed_and_holds_every_vertex() -> None:
    order = np.load(PATCH_ORDER)
    assert order[:8].tolist() == FIRST
    np.testing.assert_array_equal(np.sort(order), np.arange(6890))


@pytest.mark.slow
def test_each_patch_of_the_order_is_farthest_from_those_before(bundled_body, patches) -> None:
    exact = PyGeodesicAlgorithmExact(bundled_body.vertices, bundled_body.faces)
    for count in (1, 2, 5, 17, 64, 150, 256, 400, 511):
        nearest, _ = exact.geodesicDistances(patches.vertices[:count].tolist(), None)
        assert nearest[patches.vertices[count]] >= nearest.max() - 2e-9


def test_names_are_unique_and_begin_with_the_region(patches) -> None:
    assert len(set(patches.names)) == len(patches)
    for name, region in zip(patches.names, patches.regions, strict=True):
        assert name == region or name.rsplit(" ", 1)[0] == region


def test_saving_and_loading_changes_nothing_and_gives_the_same_bytes(patches, tmp_path) -> None:
    patches.save(tmp_path / "one.npz")
    loaded = PatchSet.load(tmp_path / "one.npz")
    loaded.save(tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert loaded.names == patches.names
    assert loaded.seed == patches.seed
    scores = np.random.default_rng(0).random((512, 3))
    np.testing.assert_array_equal(loaded.to_vertices(scores), patches.to_vertices(scores))


def test_a_file_of_something_else_is_refused(bundled_body, tmp_path) -> None:
    bundled_body.save(tmp_path / "body.npz")
    with pytest.raises(ValueError, match="does not hold W2W patches"):
        PatchSet.load(tmp_path / "body.npz")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 0}, "between 1 and"),
        ({"n": 7000}, "between 1 and"),
    ],
)
def test_wrong_arguments_are_named(bundled_body, arguments, message) -> None:
    with pytest.raises(ValueError, match=message):
        sample_patches(bundled_body, **arguments)


@pytest.mark.slow
def test_loose_vertices_and_unreached_pieces_are_refused(bundled_body) -> None:
    body = bundled_body
    extra = {
        "vertices": np.vstack([body.vertices, [[0, 0, 3.0]]]),
        "weights": body.weights[[*range(6890), 0]],
    }
    with pytest.raises(ValueError, match="belong to no face"):
        sample_patches(replace(body, mirror=None, **extra), 10)
    twice = Body(
        np.vstack([body.vertices, body.vertices + 2]),
        np.vstack([body.faces, body.faces + len(body.vertices)]),
        body.joints,
        np.vstack([body.weights, body.weights]),
    )
    with pytest.raises(ValueError, match="2 separate pieces"):
        sample_patches(twice, 1)


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10_000), low=st.floats(-1e3, 1e3), span=st.floats(0, 1e3), columns=st.integers(1, 3)
)
def test_spread_scores_never_leave_the_range_of_the_scores(patches, seed, low, span, columns) -> None:
    scores = low + span * np.random.default_rng(seed).random((512, columns))
    spread = patches.to_vertices(scores)
    assert spread.shape == (len(patches.labels), columns)
    assert (spread >= scores.min(axis=0)).all()
    assert (spread <= scores.max(axis=0)).all()


def test_shares_are_positive_and_sum_to_one(patches) -> None:
    shares = patches.interpolation
    assert shares.data.min() >= 0
    np.testing.assert_allclose(np.asarray(shares.sum(axis=1)).ravel(), 1, atol=1e-6)
    np.testing.assert_allclose(patches.to_vertices(np.full(512, 0.25)), 0.25, atol=1e-7)


def test_the_largest_share_at_a_centre_is_its_own_patch(patches) -> None:
    at_centres = patches.interpolation[patches.vertices].toarray()
    np.testing.assert_array_equal(at_centres.argmax(axis=1), np.arange(512))
    assert at_centres.max(axis=1).min() > 0.92


def test_a_peak_is_shown_as_high_as_it_is(patches) -> None:
    """A single patch that is better than all others, wherever it is."""
    for peak in (0, 100, 511):
        scores = np.full(512, 0.4)
        scores[peak] = 0.9
        spread = patches.to_vertices(scores)
        assert spread[patches.vertices[peak]] > 0.86
        assert patches.labels[spread.argmax()] == peak


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0, 1))
def test_patches_without_a_score_are_blank_and_touch_nothing(patches, seed, share) -> None:
    rng = np.random.default_rng(seed)
    scores = rng.uniform(0.2, 0.8, 512)
    missing = rng.random(512) < share
    given_scores = np.where(missing, np.nan, scores)
    spread = patches.to_vertices(given_scores)
    np.testing.assert_array_equal(np.isnan(spread), missing[patches.labels])
    if not missing.all():
        held = spread[~missing[patches.labels]]
        assert held.min() >= np.nanmin(given_scores)
        assert held.max() <= np.nanmax(given_scores)
    both = patches.to_vertices(np.column_stack([scores, given_scores]))
    np.testing.assert_allclose(both[:, 0], patches.to_vertices(scores), atol=1e-6)
    np.testing.assert_allclose(both[:, 1], spread, atol=1e-6)


def test_spreading_is_smoother_and_truer_than_cells(bundled_body, patches) -> None:
    """A wave of 40 cm across the body, known at the patches, is found again between them."""
    body = bundled_body
    truth = np.sin(body.vertices @ (2 * np.pi / 0.4 * np.array([0.6, 0.0, 0.8])))
    scores = truth[patches.vertices]
    smooth, stepped = patches.to_vertices(scores), scores[patches.labels]
    assert np.sqrt(np.mean((smooth - truth) ** 2)) < 0.6 * np.sqrt(np.mean((stepped - truth) ** 2))
    edges = np.concatenate([body.faces[:, [0, 1]], body.faces[:, [1, 2]]])
    jumps = [np.abs(field[edges[:, 0]] - field[edges[:, 1]]) for field in (smooth, stepped)]
    assert np.percentile(jumps[0], 99) < 0.65 * np.percentile(jumps[1], 99)


def test_nothing_bleeds_across_a_gap() -> None:
    """A sheet folded like a hairpin: its halves are 1 mm apart in space and far apart along it."""
    across, along = (g.ravel() for g in np.meshgrid(np.linspace(-1, 1, 81), np.linspace(0, 0.5, 21)))
    index = np.arange(81 * 21).reshape(21, 81)
    corners = [index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]]
    a, b, c, d = (corner.ravel() for corner in corners)
    triangles = np.concatenate([np.c_[a, b, c], np.c_[a, c, d]])
    folded = np.c_[np.abs(across), along, np.where(across > 0, 0.0005, -0.0005)]
    graph = StripGraph.of(folded, triangles)
    centres = np.array([index[10, 0], index[10, 80], index[10, 40], index[10, 20], index[10, 60]])
    weights = interpolation_weights(graph, centres)
    left_tip, right_tip = index[:, 0], index[:, 80]
    np.testing.assert_allclose(folded[left_tip, :2], folded[right_tip, :2])
    assert weights[left_tip][:, 1].nnz == 0
    assert weights[right_tip][:, 0].nnz == 0
    assert weights[left_tip][:, 0].min() > 0.5


@pytest.mark.parametrize(
    ("scores", "message"), [(np.zeros(5), "one row a patch"), (np.full(512, np.inf), "finite")]
)
def test_scores_that_do_not_fit_are_refused(patches, scores, message) -> None:
    with pytest.raises(ValueError, match=message):
        patches.to_vertices(scores)


def test_each_region_stands_once_by_its_best_patch(patches) -> None:
    scores = np.random.default_rng(2).integers(0, 20, len(patches)) / 20  # with many ties
    best = patches.best_of_regions(scores)
    assert sorted(patches.regions[patch] for patch in best) == sorted(set(patches.regions))
    assert (np.diff(scores[best]) <= 0).all()
    for patch in best:
        members = [n for n, region in enumerate(patches.regions) if region == patches.regions[patch]]
        assert patch == members[int(scores[members].argmax())]
