# SPDX-License-Identifier: GPL-3.0-or-later
"""Closest points on triangles are trimesh's, on thin triangles and on none, too."""

import numpy as np
import pytest

from w2w.core.adopt.registration import closest_on, closest_shares


def test_closest_points_are_trimeshs():
    theirs = pytest.importorskip("trimesh.triangles").closest_point
    rng = np.random.default_rng(4)
    triangles, points = rng.normal(size=(20_000, 3, 3)), 2 * rng.normal(size=(20_000, 3))
    triangles[::7, 2] = triangles[::7, 0] + 1e-6 * triangles[::7, 2]
    shares = closest_shares(triangles, points)
    assert shares.min() >= 0
    np.testing.assert_allclose(shares.sum(axis=1), 1, atol=1e-12)
    ours = np.einsum("nk,nka->na", shares, triangles)
    np.testing.assert_allclose(ours, theirs(triangles, points), atol=1e-6)


def test_a_triangle_without_an_area_has_closest_points_too():
    line = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    triangles = np.stack([line, np.zeros((3, 3))])[None]
    found, distance = closest_on(triangles, np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(found, np.zeros((1, 2, 3)), atol=1e-12)
    np.testing.assert_allclose(distance, [[1, 1]])
