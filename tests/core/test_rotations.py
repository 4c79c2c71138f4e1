# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations that lay one direction on another, to the last digits however far apart the two are."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.rotations import (
    continuous_quaternions,
    double_inverse,
    frame_of,
    in_axes,
    into_frame,
    rate_in_frame,
    rotation_vectors,
    smallest_rotation,
    turn_about,
)  # fmt: skip

EPS = np.finfo(float).eps


def directions(n, seed=0):
    """Random unit vectors, and the axes and diagonals where components vanish or tie."""
    random = np.random.default_rng(seed).normal(size=(n, 3))
    corners = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], float)
    every = np.concatenate([random, corners[np.abs(corners).sum(axis=1) > 0]])
    return every / np.linalg.norm(every, axis=1, keepdims=True)


def assert_rotates(rotation, start, end, tolerance):
    """A proper rotation that takes `start` to `end`."""
    np.testing.assert_allclose(np.einsum("nij,nj->ni", rotation, start), end, atol=tolerance)
    np.testing.assert_allclose(
        rotation @ rotation.swapaxes(1, 2), np.broadcast_to(np.eye(3), rotation.shape), atol=tolerance
    )
    np.testing.assert_allclose(np.linalg.det(rotation), 1, atol=tolerance)


@pytest.mark.parametrize("short_of_opposite", [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1.0, 2.0, 3.0])
def test_the_turn_is_exact_however_nearly_opposite_the_directions_are(short_of_opposite):
    start = directions(200)
    square = np.cross(start, directions(200, seed=1)[::-1])
    kept = np.linalg.norm(square, axis=1) > 0.1
    start, square = start[kept], square[kept] / np.linalg.norm(square[kept], axis=1, keepdims=True)
    end = -np.cos(short_of_opposite) * start + np.sin(short_of_opposite) * square
    rotation = smallest_rotation(start, end)
    assert len(start) > 150
    assert_rotates(rotation, start, end, 16 * EPS)
    # the least angle is the angle between the two
    found = Rotation.from_matrix(rotation).magnitude()
    np.testing.assert_allclose(found, np.pi - short_of_opposite, atol=64 * EPS)


def test_nearly_opposite_directions_that_once_came_out_wrong():
    start, end = np.array([[0, 1, 0.99999]]), np.array([[0, -1.0, -1]])
    start, end = (v / np.linalg.norm(v) for v in (start, end))
    assert_rotates(smallest_rotation(start, end), start, end, 16 * EPS)


def test_the_turn_is_about_the_axis_square_to_both():
    """What lies square to both directions stays, from nearly alike to nearly opposite."""
    angles = np.pi - np.geomspace(1e-6, 3.1, 60)
    start = np.array([1.0, 0, 0])
    end = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    expected = Rotation.from_rotvec(angles[:, None] * [0, 0, 1]).as_matrix()
    np.testing.assert_allclose(smallest_rotation(start, end), expected, atol=16 * EPS)
    turned = smallest_rotation(end, np.broadcast_to(start, end.shape))
    np.testing.assert_allclose(turned, expected.swapaxes(1, 2), atol=16 * EPS)


def test_directions_on_both_sides_of_opposite_may_come_together():
    start = np.array([[0, 0, 3.0], [0, 0, 1], [1, 0, 0]])
    end = np.array([[0, 0, -1.0], [0, 0, 5], [0, 1, 0]])
    unit_ends = end / np.linalg.norm(end, axis=1, keepdims=True)
    unit_starts = start / np.linalg.norm(start, axis=1, keepdims=True)
    together = smallest_rotation(start, end)
    assert_rotates(together, unit_starts, unit_ends, 4 * EPS)
    np.testing.assert_array_equal(together[1], np.eye(3))
    for one, a, b in zip(together, start, end, strict=True):
        np.testing.assert_allclose(one, smallest_rotation(a, b), atol=4 * EPS)


def test_turns_equal_scipy_and_frames_are_square():
    axes = directions(50)
    angles = np.linspace(-7, 7, len(axes))
    expected = Rotation.from_rotvec(angles[:, None] * axes).as_matrix()
    np.testing.assert_allclose(turn_about(axes, angles), expected, atol=16 * EPS)
    left, up = directions(50, seed=2), directions(50, seed=3)
    kept = np.linalg.norm(np.cross(left, up), axis=1) > 0.1
    frames = frame_of(left[kept], up[kept])
    identity = np.broadcast_to(np.eye(3), frames.shape)
    np.testing.assert_allclose(frames.swapaxes(1, 2) @ frames, identity, atol=64 * EPS)
    np.testing.assert_allclose(frames[..., 2], up[kept], atol=4 * EPS)
    np.testing.assert_allclose(np.linalg.det(frames), 1, atol=64 * EPS)
    assert ((frames[..., 0] * left[kept]).sum(axis=1) > 0).all()


@pytest.fixture
def spins():
    """Rotations (40, 3, 3, 3) that go round more than once, about an axis each."""
    angles = np.linspace(0, 5 * np.pi, 40)[:, None, None] * np.array([[1.0], [-0.7], [0.2]])
    axes = np.array([[0, 0, 1.0], [0.6, 0, 0.8], [-0.48, 0.64, 0.6]])
    return Rotation.from_rotvec((angles * axes).reshape(-1, 3)).as_matrix().reshape(40, 3, 3, 3)


def test_quaternions_are_those_of_the_rotations_and_never_jump(spins):
    quaternions = continuous_quaternions(spins)
    back = Rotation.from_quat(quaternions.transpose(1, 2, 0).reshape(-1, 4), scalar_first=True).as_matrix()
    np.testing.assert_allclose(back.reshape(spins.shape), spins, atol=8 * EPS)
    assert ((quaternions[:, 1:] * quaternions[:, :-1]).sum(axis=0) > 0.9).all()


@pytest.mark.parametrize("wrong", [np.zeros((3, 3)), 1.1 * np.eye(3), np.diag([1.0, 1, -1])])
def test_what_is_no_rotation_has_no_quaternion(spins, wrong):
    spins[3, 1] = wrong
    with pytest.raises(ValueError, match="no rotation"):
        continuous_quaternions(spins)


def test_rotation_vectors_are_scipys_at_any_angle():
    """From nothing to half a turn, either way round, and about axes whose components vanish or tie."""
    angles = [0, 1e-9, 0.99e-3, 1.01e-3, 1, np.pi / 2, 3, np.pi - 1e-9, np.pi]
    turns = Rotation.from_rotvec(np.concatenate([angle * directions(500) for angle in angles])).as_matrix()
    found = rotation_vectors(turns.reshape(len(angles), -1, 3, 3))
    np.testing.assert_allclose(
        found.reshape(-1, 3), Rotation.from_matrix(turns).as_rotvec(), rtol=4 * EPS, atol=4 * EPS
    )


def test_rotations_in_other_axes(spins):
    """The same axes for all, or each its own."""
    one, own = spins[7, 1], spins[11]
    np.testing.assert_allclose(in_axes(spins, one), one.T @ spins @ one, atol=8 * EPS)
    np.testing.assert_allclose(
        in_axes(spins[:, 1:], own[1:]), (own.swapaxes(1, 2) @ spins @ own)[:, 1:], atol=8 * EPS
    )


def test_a_spinning_frames_rate_and_gravity_are_those_of_a_gyroscope_on_it_at_any_length_of_the_quaternion():
    """One turn a second about an axis of the world; the quaternion grows, which is no turn."""
    speed, times = 2 * np.pi, np.linspace(0, 1, 50)
    axis = np.array([2.0, -1.0, 2.0]) / 3
    half, grown = speed * times / 2, 1 + times
    q = np.concatenate([np.cos(half)[None], axis[:, None] * np.sin(half)]) * grown
    turning = np.concatenate([-np.sin(half)[None], axis[:, None] * np.cos(half)]) * (speed / 2) * grown
    q_dot = turning + q / grown
    rate, gravity = np.empty((3, 50)), np.empty((3, 50))
    rate_in_frame(q, double_inverse(q), q_dot, rate)
    np.testing.assert_allclose(rate, np.tile(speed * axis[:, None], 50), atol=1e-12)
    down = np.tile(np.array([0.0, 0.0, -9.81])[:, None], 50)
    into_frame(q, double_inverse(q), down, gravity)
    turned = Rotation.from_rotvec(speed * times[:, None] * axis).inv().apply(down.T)
    np.testing.assert_allclose(gravity.T, turned, atol=1e-12)
