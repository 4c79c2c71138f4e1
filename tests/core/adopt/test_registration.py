# SPDX-License-Identifier: GPL-3.0-or-later
"""Closest points on triangles, on thin ones and on none, too, and fits that a last bit does not change."""

import subprocess
import sys

import numpy as np
from scipy.optimize import nnls

from w2w.core.adopt.registration import closest_on, shares_on


def test_closest_points_and_their_shares_are_those_of_least_squares():
    rng = np.random.default_rng(4)
    triangles, points = rng.normal(size=(2000, 3, 3)), 2 * rng.normal(size=(2000, 3))
    triangles[::7, 2] = triangles[::7, 0] + 1e-6 * triangles[::7, 2]
    found, distance = closest_on(triangles[:, None], points)
    shares = shares_on(triangles, found[:, 0])
    assert shares.min() >= 0
    np.testing.assert_allclose(shares.sum(axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.einsum("nk,nka->na", shares, triangles), found[:, 0], atol=1e-6)
    # shares that are positive and, by a heavy row, sum to 1
    heavy = np.concatenate([triangles.swapaxes(1, 2), np.full((2000, 1, 3), 1e4)], axis=1)
    wanted = np.concatenate([points, np.full((2000, 1), 1e4)], axis=1)
    least = [nnls(matrix, right)[1] for matrix, right in zip(heavy, wanted, strict=True)]
    np.testing.assert_allclose(distance[:, 0], least, atol=1e-5)


def test_a_triangle_without_an_area_has_closest_points_too():
    line = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    triangles = np.stack([line, np.zeros((3, 3))])[None]
    found, distance = closest_on(triangles, np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(found, np.zeros((1, 2, 3)), atol=1e-12)
    np.testing.assert_allclose(distance, [[1, 1]])
    shares = shares_on(triangles[0], found[0])
    assert shares.min() >= 0
    np.testing.assert_allclose(shares.sum(axis=1), 1)


def test_faces_that_share_the_closest_point_are_equally_near():
    """A last bit that differs between processors does not choose between them."""
    rng = np.random.default_rng(1)
    edge, sides = rng.normal(size=(500, 1, 2, 3)), rng.normal(size=(500, 2, 1, 3))
    triangles = np.concatenate([np.repeat(edge, 2, axis=1), sides], axis=2)
    middle = triangles.mean(axis=(1, 2))
    outside = edge[:, 0].mean(axis=1) + 3 * (edge[:, 0].mean(axis=1) - middle)
    found, distance = closest_on(triangles, outside)
    shared = np.linalg.norm(found[:, 0] - found[:, 1], axis=1) < 1e-12
    assert shared.sum() > 100
    np.testing.assert_array_equal(distance[shared, 0], distance[shared, 1])


def test_trimesh_is_imported_when_a_closest_point_is_asked_for():
    users = "w2w.core.adopt.smpl, w2w.core.patches.correspondence"
    code = f"import sys, {users}; sys.exit('trimesh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
