# SPDX-License-Identifier: GPL-3.0-or-later
"""Our own body, posed, scaled and cut otherwise, is found again point by point."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms, skin, skinning_transforms
from w2w.core.patches.correspondence import Character, correspond
from w2w.core.retargeting.bone_maps import REQUIRED_JOINTS

NEEDED = [JOINT_INDEX[name] for name in REQUIRED_JOINTS]


def character(body, joints=range(N_JOINTS), lowered=0.0, unit=1.0, turn=None):
    """Our body as somebody else's: arms lowered, in another unit, turned, with bones for some joints."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    for side, sign in (("left", 1), ("right", -1)):
        rotations[0, JOINT_INDEX[f"{side}_shoulder"]] = Rotation.from_rotvec(
            [0, sign * lowered, 0]
        ).as_matrix()
    motion = Motion(rotations, body.joints[:1], 30)
    turn = np.eye(3) if turn is None else turn
    vertices = skin(body, skinning_transforms(body, motion))[0] @ turn.T * unit
    places = joint_transforms(body, motion)[1][0] @ turn.T * unit
    return Character(vertices, body.faces, body.weights, {joint: places[joint] for joint in joints})


def found_at(points, body):
    """Where on our body the points are."""
    return np.einsum("vc,vca->va", points.shares, body.vertices[body.faces[points.faces]])


@pytest.mark.parametrize(
    ("options", "median", "most"),
    [
        ({}, 1e-6, 1e-3),
        ({"lowered": 0.8}, 1e-3, 0.02),
        ({"unit": 100.0, "turn": Rotation.from_euler("xz", [90, 40], degrees=True).as_matrix()}, 1e-4, 5e-3),
        ({"joints": NEEDED, "unit": 0.01}, 5e-3, 0.03),
    ],
)
def test_each_vertex_is_found_again(bundled_body, options, median, most):
    points = correspond(character(bundled_body, **options), bundled_body)
    gap = np.linalg.norm(found_at(points, bundled_body) - bundled_body.vertices, axis=1)
    assert np.median(gap) < median
    assert np.quantile(gap, 0.99) < most
    np.testing.assert_allclose(points.shares.sum(axis=1), 1)


def test_long_arms_and_a_thick_trunk_are_still_arms_and_trunk(bundled_body):
    figure = character(bundled_body)
    vertices, joints = figure.vertices.copy(), {k: v.copy() for k, v in figure.joints.items()}
    beyond = np.abs(vertices[:, 0]) - 0.25  # stretch all outward of the shoulders by half
    vertices[:, 0] += np.sign(vertices[:, 0]) * 0.5 * np.maximum(beyond, 0)
    for place in joints.values():
        place[0] += np.sign(place[0]) * 0.5 * max(abs(place[0]) - 0.25, 0)
    points = correspond(replace(figure, vertices=vertices, joints=joints), bundled_body)
    gap = np.linalg.norm(found_at(points, bundled_body) - bundled_body.vertices, axis=1)
    assert np.quantile(gap, 0.95) < 0.04


def test_a_hand_at_the_thigh_is_no_thigh(bundled_body):
    points = correspond(character(bundled_body, lowered=1.4), bundled_body)
    joints = np.arange(N_JOINTS)
    hands = np.isin(joints, [JOINT_INDEX[f"{s}_{p}"] for s in ("left", "right") for p in ("wrist", "hand")])
    weights = bundled_body.weights[:, hands].sum(axis=1)
    on_ours = bundled_body.weights[bundled_body.faces[points.faces]].mean(axis=1)[:, hands].sum(axis=1)
    assert on_ours[weights > 0.9].min() > 0.3
    assert on_ours[weights < 0.01].max() < 0.5


def test_vertices_that_no_bone_moves_go_with_their_neighbours(bundled_body):
    figure = character(bundled_body)
    weights = figure.weights.copy()
    weights[::50] = 0
    points = correspond(replace(figure, weights=weights), bundled_body)
    gap = np.linalg.norm(found_at(points, bundled_body) - bundled_body.vertices, axis=1)
    assert np.quantile(gap, 0.99) < 5e-3
    with pytest.raises(ValueError, match="no bone that plays a joint"):
        correspond(replace(figure, weights=np.zeros_like(weights)), bundled_body)
