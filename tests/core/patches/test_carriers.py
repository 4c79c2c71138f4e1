# SPDX-License-Identifier: GPL-3.0-or-later
"""Carrier triangles: shape, direction and steadiness against the obvious choice of nearest vertices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, MIRRORED_JOINTS, N_JOINTS, Body
from w2w.core.motion.motion import Motion
from w2w.core.patches.carriers import (
    MIN_HEIGHT,
    RANGES,
    carrier_triangles,
    random_poses,
    triangle_rotation_error,
)
from w2w.core.patches.patches import farthest_points
from w2w.core.patches.strip_graph import StripGraph


@pytest.fixture(scope="module")
def graph(bundled_body) -> StripGraph:
    return StripGraph.of(bundled_body.vertices, bundled_body.faces)


@pytest.fixture(scope="module")
def centres(graph) -> np.ndarray:
    return farthest_points(graph, 256, 0)


@pytest.fixture(scope="module")
def triangles(bundled_body, graph, centres) -> np.ndarray:
    return carrier_triangles(bundled_body, graph, centres)


def heights(body: Body, triangles: np.ndarray) -> np.ndarray:
    corners = body.vertices[triangles]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    double_area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    return double_area / sides.max(axis=1)


def smallest_angles(body: Body, triangles: np.ndarray) -> np.ndarray:
    corners = body.vertices[triangles]
    one, other = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (one * other).sum(axis=2) / np.linalg.norm(one, axis=2) / np.linalg.norm(other, axis=2)
    return np.degrees(np.arccos(cosine)).min(axis=1)


def test_triangles_are_tall_and_near_equilateral(bundled_body, triangles) -> None:
    assert heights(bundled_body, triangles).min() >= MIN_HEIGHT
    angles = smallest_angles(bundled_body, triangles)
    assert angles.min() > 30
    assert np.median(angles) > 50


def test_triangles_face_outward_and_lie_at_their_centres(bundled_body, centres, triangles) -> None:
    corners = bundled_body.vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("na,na->n", normal, bundled_body.vertex_normals[centres]) > 0).all()
    offset = np.linalg.norm(corners.mean(axis=1) - bundled_body.vertices[centres], axis=1)
    assert np.median(offset) < 0.008
    assert offset.max() < 0.03


def test_triangles_are_steadier_than_the_three_nearest_vertices(
    bundled_body, graph, centres, triangles
) -> None:
    """On poses other than those that they were chosen by."""
    nearest = np.array([near[:3] for near in graph.neighbourhoods(centres, 0.04, 3)])
    poses = random_poses(60, seed=2024)
    ours = np.degrees(triangle_rotation_error(bundled_body, triangles, poses))
    theirs = np.degrees(triangle_rotation_error(bundled_body, nearest, poses))
    assert np.median(ours) < np.median(theirs)
    assert ours.mean() < 0.6 * theirs.mean()
    assert np.percentile(ours, 90) < 0.7 * np.percentile(theirs, 90)
    assert (ours > 60).sum() < 0.1 * (theirs > 60).sum()
    assert ours.max() < 100


def test_the_choice_is_the_same_every_time(bundled_body, graph, centres, triangles) -> None:
    np.testing.assert_array_equal(carrier_triangles(bundled_body, graph, centres[:64]), triangles[:64])


def one_triangle(weights: np.ndarray) -> Body:
    """A horizontal triangle around the left knee with the same weights at every corner."""
    joints = np.random.default_rng(0).normal(size=(N_JOINTS, 3))
    corners = joints[JOINT_INDEX["left_knee"]] + np.array([[0.1, 0, 0], [-0.1, 0.1, 0], [-0.1, -0.1, 0]])
    return Body(corners, np.array([[0, 1, 2]]), joints, np.tile(weights, (3, 1)))


def knee_turned(degrees: float) -> Motion:
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    rotations[0, JOINT_INDEX["left_knee"]] = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
    return Motion(rotations, np.zeros((1, 3)), 1)


def test_a_rigid_triangle_does_not_turn_against_its_bone() -> None:
    weights = np.zeros(N_JOINTS)
    weights[JOINT_INDEX["left_knee"]] = 1
    error = triangle_rotation_error(one_triangle(weights), np.array([[0, 1, 2]]), random_poses(20, 3))
    np.testing.assert_allclose(error, 0, atol=1e-7)


@pytest.mark.parametrize("degrees", [30.0, 90.0, 130.0])
def test_an_evenly_blended_triangle_turns_half_as_far_as_the_joint(degrees: float) -> None:
    """In the plane of rotation, (1 + R) / 2 turns by half the angle and shrinks."""
    weights = np.zeros(N_JOINTS)
    weights[JOINT_INDEX["left_knee"]] = weights[JOINT_INDEX["left_hip"]] = 0.5
    error = triangle_rotation_error(one_triangle(weights), np.array([[0, 1, 2]]), knee_turned(degrees))
    assert np.degrees(error[0]) == pytest.approx(degrees / 2, abs=1e-6)


def test_random_poses_stay_within_their_ranges_and_mirror_the_sides() -> None:
    poses = random_poses(400, seed=1)
    for joint, name in enumerate(JOINT_NAMES):
        low, high = np.transpose(RANGES[name.split("_")[-1]])
        angles = Rotation.from_matrix(poses.rotations[:, joint]).as_euler("xyz", degrees=True)
        if np.abs([low[1], high[1]]).max() >= 90 or name.endswith("shoulder"):
            continue
        sign = np.array([1, -1, -1]) if name.startswith("right_") else np.ones(3)
        assert (angles * sign >= low - 1e-6).all()
        assert (angles * sign <= high + 1e-6).all()
    knees = [JOINT_INDEX["left_knee"], MIRRORED_JOINTS[JOINT_INDEX["left_knee"]]]
    bent = Rotation.from_matrix(poses.rotations[:, knees].reshape(-1, 3, 3)).as_rotvec()[:, 0]
    assert bent.min() > -0.1
    assert bent.max() > 2
