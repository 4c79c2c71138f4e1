# SPDX-License-Identifier: GPL-3.0-or-later
"""How far limbs are sunk into the body: boxes, whose inside is known, and the body in known poses."""

import numpy as np
import pytest
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.scene.cloth.clear import ARM, LEG, closed, inside, limb, pushed_out, times_inside, trunk

CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def boxes(*offsets):
    """Unit boxes with faces outward, each moved by so much."""
    vertices = np.concatenate([CORNERS + offset for offset in offsets])
    faces = [[8 * box + corner for corner in side] for box in range(len(offsets)) for side in SIDES]
    return BVHTree.FromPolygons(vertices.tolist(), faces)


def posed(body, **degrees):
    """One frame of the body in the T-pose but for some joints, turned about the axis from front to back."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    for joint, angle in degrees.items():
        rotations[0, JOINT_INDEX[joint]] = Rotation.from_euler("y", angle, degrees=True).as_matrix()
    return Motion(rotations, body.joints[:1], 60.0)


def test_points_are_in_a_box_or_not():
    tree = boxes((0, 0, 0))
    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 2, size=(200, 3))
    expected = ((points > 0) & (points < 1)).all(axis=1)
    assert 0 < expected.sum() < len(points)
    assert [times_inside(tree, Vector(point)) for point in points] == expected.astype(int).tolist()
    assert inside(tree, points) == expected.sum()


@pytest.mark.parametrize(("point", "times"), [((0.25, 0.4, 0.3), 1), ((0.75, 0.4, 0.3), 2), ((2, 0, 0), 0)])
def test_where_two_parts_overlap_a_point_is_inside_twice(point, times):
    assert times_inside(boxes((0, 0, 0), (0.5, 0.1, 0.1)), Vector(point)) == times


def test_the_trunk_is_closed_where_the_arms_were_cut_off(bundled_body):
    (tree,) = closed(bundled_body, trunk(bundled_body), posed(bundled_body))
    place = {name: Vector(bundled_body.joints[number]) for name, number in JOINT_INDEX.items()}
    for name in ("pelvis", "spine2", "head", "left_knee", "right_ankle"):
        assert times_inside(tree, place[name]) == 1, name
    for name in ("left_elbow", "right_elbow", "left_wrist"):
        assert times_inside(tree, place[name]) == 0, name


@pytest.mark.parametrize(
    ("side", "down"), [("left", 80.0), pytest.param("right", -80.0, marks=pytest.mark.slow)]
)
def test_an_arm_that_hangs_is_sunk_into_the_trunk_and_one_held_out_is_not(bundled_body, side, down):
    arm, middle = limb(bundled_body, side, ARM), trunk(bundled_body)
    assert len(arm) > 100
    sunk = []
    for angle in (0.0, 1.1 * down):
        motion = posed(bundled_body, **{f"{side}_shoulder": angle})
        (tree,), (points,) = closed(bundled_body, middle, motion), pushed_out(bundled_body, arm, motion)
        sunk.append(inside(tree, points))
    assert sunk[0] == 0
    assert sunk[1] > 0


def test_a_limb_begins_some_way_down_its_first_bone(bundled_body):
    hip, knee = (bundled_body.joints[JOINT_INDEX[f"left_{name}"]] for name in LEG[:2])
    heights = bundled_body.vertices[limb(bundled_body, "left", LEG), 2]
    assert heights.max() < hip[2] - 0.3 * (hip[2] - knee[2])
    assert heights.min() < 0.05
