# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms that are sunk into the trunk are turned outward while cloth is simulated, others stay as they are."""

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.garments.cut import cut
from w2w.core.motion.motion import Motion
from w2w.core.motion.run_up import with_run_up
from w2w.core.motion.skinning import joint_transforms, skin, skinning_transforms
from w2w.scene.base.body import add_skinned
from w2w.scene.base.steps import without_pauses
from w2w.scene.cloth import bake as following, clear
from w2w.scene.cloth.bake import DressedBody, cover_of, follow
from w2w.scene.cloth.clear import ANGLES, outward, with_clear_arms
from w2w.scene.cloth.garments import KIND, dress


def standing(body, left=0.0, right=0.0, frames=2):
    """A body that stands with its arms so many degrees below the T-pose."""
    rotations = np.tile(np.eye(3), (frames, N_JOINTS, 1, 1))
    for side, angle in (("left", left), ("right", -right)):
        turn = Rotation.from_euler("y", angle, degrees=True).as_matrix()
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = turn
    return Motion(rotations, np.tile(body.joints[0], (frames, 1)), 60.0)


def wrist(body, motion, side):
    return joint_transforms(body, motion)[1][0, JOINT_INDEX[f"{side}_wrist"]]


@pytest.mark.slow
def test_arms_that_are_clear_stay_as_they_are(bundled_body):
    motion = standing(bundled_body, left=40, right=20)
    np.testing.assert_array_equal(with_clear_arms(bundled_body, motion).rotations, motion.rotations)


@pytest.mark.slow
@pytest.mark.parametrize(("side", "other"), [("left", "right"), ("right", "left")])
def test_only_an_arm_that_is_sunk_is_turned_and_outward(bundled_body, side, other, monkeypatch):
    monkeypatch.setattr(clear, "ARM_AS_CLEAR", 0.0)
    motion = standing(bundled_body, **{side: 80.0})
    cleared = with_clear_arms(bundled_body, motion)
    found, own = wrist(bundled_body, cleared, side), wrist(bundled_body, motion, side)
    assert abs(found[0]) > abs(own[0]) + 0.02
    assert found[2] > own[2]
    np.testing.assert_array_equal(wrist(bundled_body, cleared, other), wrist(bundled_body, motion, other))
    assert outward(bundled_body, cleared, side) == 0


def test_the_angle_is_the_least_that_clears(bundled_body, monkeypatch):
    monkeypatch.setattr(clear, "ARM_AS_CLEAR", 0.0)
    angle = outward(bundled_body, standing(bundled_body, left=80.0), "left")
    assert 0 < angle < ANGLES[-1]
    step = ANGLES[1] - ANGLES[0]
    assert outward(bundled_body, standing(bundled_body, left=80.0 - angle), "left") == 0
    assert outward(bundled_body, standing(bundled_body, left=80.0 - angle + step), "left") > 0


def test_where_turning_does_not_help_the_arm_stays(bundled_body, monkeypatch):
    monkeypatch.setattr(clear, "inside", lambda _tree, _points: 7)
    assert outward(bundled_body, standing(bundled_body, left=80.0), "left") == 0


@pytest.mark.slow
def test_far_from_the_origin_arms_are_held_as_clear(bundled_body):
    near = standing(bundled_body, left=88.0)
    far = Motion(near.rotations, near.pelvis + (5e5, 5e6, 300.0), near.rate)
    assert outward(bundled_body, far, "left") == outward(bundled_body, near, "left") > 0


@pytest.mark.slow
def test_sensors_are_carried_back_to_the_clips_own_pose(body_in_scene, bundled_body, patches):
    """A shirt that goes with the skin, so that where its sensors belong is known."""
    body_in_scene.armature.location = (0.3, -0.2, 0.1)
    cloth = cut("tshirt", bundled_body).cloth
    item = add_skinned(cloth, body_in_scene.armature, bpy.context.scene.collection, "Shirt")
    item[KIND] = "tshirt"
    bpy.context.view_layer.update()
    own = cover_of(item, body_in_scene.mesh, patches)
    motion = standing(bundled_body, left=88.0, right=88.0)
    frames = follow(DressedBody(body_in_scene.mesh, [item], [own]), motion, patches)
    worn = without_pauses(frames)
    away = {}
    for name, posed in (("own", motion), ("cleared", with_clear_arms(bundled_body, motion))):
        moved, before = with_run_up(posed)
        points = skin(cloth, skinning_transforms(cloth, moved)) + (0.3, -0.2, 0.1)
        places = own.matrices(points[before:, own.triangles])[:, :, :3, 3]
        away[name] = np.linalg.norm(worn.matrices[:, :, :3, 3] - places, axis=2).max()
    assert away["own"] < 0.005
    assert away["cleared"] > 0.01


@pytest.mark.slow
def test_arms_are_cleared_for_our_garments_alone(body_in_scene, bundled_body, patches, monkeypatch):
    item = dress(body_in_scene.mesh, "tshirt")
    asked = []
    monkeypatch.setattr(following, "with_clear_arms", lambda _, motion: asked.append(motion) or motion)
    own = cover_of(item, body_in_scene.mesh, patches)
    for _ in range(2):
        frames = follow(DressedBody(body_in_scene.mesh, [item], [own]), standing(bundled_body), patches)
        next(frames)
        frames.close()
        item.pop(KIND, None)  # somebody else's from now on
    assert len(asked) == 1
