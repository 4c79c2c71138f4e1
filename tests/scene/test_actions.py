# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions as actions: what is written is read back, and plays as it should."""

import bpy
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_NAMES
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.scene.base.actions import (
    InexpressibleActionError,
    bone_curves,
    read_action,
    show_action,
    write_action,
)
from w2w.scene.base.body import add_body
from w2w.scene.base.fcurves import action_curves


def turn_angles(motion, other):
    """Angles between the joints' rotations, degrees."""
    turns = np.swapaxes(motion.rotations, -1, -2) @ other.rotations
    return np.degrees(Rotation.from_matrix(turns.reshape(-1, 3, 3)).magnitude())


def assert_same_motion(read, motion):
    assert read.n_frames == motion.n_frames
    assert read.rate == pytest.approx(motion.rate, rel=1e-5)
    assert turn_angles(read, motion).max() < 1e-3
    np.testing.assert_allclose(read.pelvis, motion.pelvis, atol=1e-5)  # metres far apart in one frame


@pytest.mark.parametrize("scene_rate", [24, 30, 60])
def test_a_motion_comes_back_at_any_rate_of_the_scene(body_in_scene, waving, scene_rate):
    bpy.context.scene.render.fps = scene_rate
    action = write_action(body_in_scene.armature, waving)
    read = read_action(body_in_scene.armature, action)
    assert_same_motion(read, waving)
    assert (read.activity, read.subject, read.clip) == ("waving", "one", "clip")


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**16), n_frames=st.integers(2, 12), rate=st.floats(5, 240))
def test_any_rotations_come_back(body_in_scene, seed, n_frames, rate):
    turns = Rotation.random(n_frames * 24, random_state=seed).as_matrix().reshape(n_frames, 24, 3, 3)
    motion = Motion(turns, np.random.default_rng(seed).normal(size=(n_frames, 3)), rate)
    action = write_action(body_in_scene.armature, motion)
    assert_same_motion(read_action(body_in_scene.armature, action), motion)
    bpy.data.actions.remove(action)


def test_blender_poses_the_bones_as_our_kinematics(body_in_scene, bundled_body, waving):
    armature = body_in_scene.armature
    bpy.context.scene.render.fps = 30
    show_action(armature, write_action(armature, waving))
    _, positions = joint_transforms(bundled_body, waving)
    for frame in (0, 31, 59):
        bpy.context.scene.frame_set(frame + 1)
        posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
        heads = np.array([posed.pose.bones[name].head for name in JOINT_NAMES])
        np.testing.assert_allclose(heads, positions[frame], atol=2e-6)


def test_between_frames_a_turn_takes_the_short_way(body_in_scene):
    """Quaternions whose sign jumps would swing the other way round between two keys."""
    angles = np.linspace(0, 4 * np.pi, 40)
    turns = np.tile(np.eye(3), (40, 24, 1, 1))
    turns[:, 18] = Rotation.from_rotvec(angles[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    armature = body_in_scene.armature
    motion = Motion(turns, np.tile([0.0, 0.0, 0.9], (40, 1)), 24.0)
    show_action(armature, write_action(armature, motion))
    rest = np.array(armature.data.bones["left_elbow"].matrix_local)[:3, :3]
    for frame in range(39):
        bpy.context.scene.frame_set(frame + 1, subframe=0.5)
        basis = np.array(armature.pose.bones["left_elbow"].matrix_basis)[:3, :3]
        middle = Rotation.from_rotvec([0, 0, (angles[frame] + angles[frame + 1]) / 2]).as_matrix()
        np.testing.assert_allclose(rest @ basis @ rest.T, middle, atol=1e-5)


def test_channels_at_rest_have_one_key(body_in_scene):
    turns = np.tile(np.eye(3), (100, 24, 1, 1))
    action = write_action(body_in_scene.armature, Motion(turns, np.zeros((100, 3)), 24.0))
    curves = next(action_curves(action))
    assert len(curves) == 24 * 4 + 3
    assert all(len(curve.keyframe_points) == 1 for curve in curves)


def test_handles_come_with_the_first_edit(body_in_scene, waving):
    """They are not written; Blender itself lays them beside their keys where they begin to matter."""
    curve = bone_curves(body_in_scene.armature, write_action(body_in_scene.armature, waving))["left_elbow"][
        "rotation_quaternion", 0
    ]
    straight = [curve.evaluate(frame) for frame in (7.25, 20.5)]
    keys = {point.co[0]: point.co[1] for point in curve.keyframe_points}
    first, second = sorted(keys)[5:7]
    assert curve.evaluate((first + second) / 2) == pytest.approx((keys[first] + keys[second]) / 2, abs=1e-6)
    curve.keyframe_points.insert(100, 0.0)
    point = curve.keyframe_points[5]
    assert point.handle_left[0] < point.co[0] < point.handle_right[0]
    assert [curve.evaluate(frame) for frame in (7.25, 20.5)] == straight


def test_poses_keyed_by_hand_are_read_at_whole_frames(body_in_scene):
    armature = body_in_scene.armature
    bone = armature.pose.bones["left_shoulder"]
    for frame, angle in ((1, 0.0), (11, 0.5), (21, 0.0)):
        bone.rotation_quaternion = (np.cos(angle / 2), np.sin(angle / 2), 0, 0)
        bone.keyframe_insert("rotation_quaternion", frame=frame)
    read = read_action(armature, armature.animation_data.action)
    assert (read.n_frames, read.rate) == (21, 24.0)
    bpy.context.scene.frame_set(6)
    expected = Rotation.from_matrix(np.array(bone.matrix_basis)[:3, :3]).magnitude()
    assert Rotation.from_matrix(read.rotations[5, 16]).magnitude() == pytest.approx(expected, abs=1e-5)


def test_euler_bones_are_read_too(body_in_scene):
    armature = body_in_scene.armature
    bone = armature.pose.bones["left_knee"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = (0.3, -0.2, 0.1)
    bone.keyframe_insert("rotation_euler", frame=1)
    bpy.context.view_layer.update()
    read = read_action(armature, armature.animation_data.action)
    rest = np.array(armature.data.bones["left_knee"].matrix_local)[:3, :3]
    np.testing.assert_allclose(
        read.rotations[0, 4], rest @ np.array(bone.matrix_basis)[:3, :3] @ np.linalg.inv(rest), atol=1e-6
    )


def test_a_muted_curve_does_not_count(body_in_scene, waving):
    armature = body_in_scene.armature
    action = write_action(armature, waving)
    for curve in bone_curves(armature, action)["left_elbow"].values():
        curve.mute = True
    read = read_action(armature, action)
    np.testing.assert_allclose(read.rotations[:, 18], np.tile(np.eye(3), (60, 1, 1)), atol=1e-6)


@pytest.mark.parametrize(("prop", "word"), [("scale", "scales"), ("location", "off its joint")])
def test_what_a_motion_cannot_tell_is_refused(body_in_scene, prop, word):
    armature = body_in_scene.armature
    bone = armature.pose.bones["left_knee"]
    setattr(bone, prop, (0.5, 0.5, 0.5))
    bone.keyframe_insert(prop, frame=1)
    with pytest.raises(InexpressibleActionError, match=f"{word}.*|.*left_knee.*{word}"):
        read_action(armature, armature.animation_data.action)


def test_an_action_of_something_else_is_refused(body_in_scene):
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.active_object
    cube.keyframe_insert("location", frame=1)
    with pytest.raises(ValueError, match="moves no bone"):
        read_action(body_in_scene.armature, cube.animation_data.action)


@pytest.mark.skipif("slots" not in bpy.types.Action.bl_rna.properties, reason="slots came with Blender 4.4")
@pytest.mark.usefixtures("empty_file")
def test_of_two_slots_the_one_played_is_read(bundled_body, waving):
    first, second = add_body(bundled_body), add_body(bundled_body)
    action = write_action(first.armature, waving)
    still = Motion(np.tile(np.eye(3), (5, 24, 1, 1)), np.tile([0.0, 0.0, 2.0], (5, 1)), 24.0)
    slot = action.slots.new("OBJECT", "another")
    source = write_action(second.armature, still)
    bag = action.layers[0].strips[0].channelbag(slot, ensure=True)
    for curve in next(action_curves(source)):
        copy = bag.fcurves.new(curve.data_path, index=curve.array_index)
        copy.keyframe_points.insert(1, curve.keyframe_points[0].co[1])
    for objects, chosen in ((first, action.slots[0]), (second, slot)):
        show_action(objects.armature, action)
        objects.armature.animation_data.action_slot = chosen
    assert read_action(first.armature, action).pelvis[10, 0] == pytest.approx(waving.pelvis[10, 0], abs=1e-6)
    np.testing.assert_allclose(read_action(second.armature, action).pelvis[0], (0, 0, 2), atol=1e-6)


def test_actions_are_kept_and_played(body_in_scene, waving):
    armature = body_in_scene.armature
    action = write_action(armature, waving, "Waving 1")
    assert action.name == "Waving 1"
    assert action.use_fake_user
    show_action(armature, action)
    assert armature.animation_data.action == action
