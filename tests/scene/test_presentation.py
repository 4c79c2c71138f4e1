# SPDX-License-Identifier: GPL-3.0-or-later
"""The way a body faces, by which its picture is taken from the front."""

import bpy
import numpy as np
import pytest

from w2w.scene.presentation import facing, neutral, stage


@pytest.mark.parametrize("degrees", [0, 50, -130])
def test_a_body_faces_where_its_hips_and_its_armature_turn(body_in_scene, degrees):
    armature = body_in_scene.armature
    pelvis = armature.pose.bones["pelvis"]
    turn = np.radians(degrees)
    pelvis.rotation_mode = "XYZ"
    rest = pelvis.bone.matrix_local.to_3x3()
    around_z = rest.inverted() @ type(rest).Rotation(turn, 3, "Z") @ rest
    pelvis.rotation_euler = around_z.to_euler()
    bpy.context.view_layer.update()
    assert facing(body_in_scene.mesh) == pytest.approx(turn, abs=1e-4)
    armature.rotation_euler.z = 0.3
    bpy.context.view_layer.update()
    assert facing(body_in_scene.mesh) == pytest.approx(turn + 0.3, abs=1e-4)


def test_a_stage_leaves_nothing(body_in_scene):
    before = [*bpy.data.scenes], [*bpy.data.objects], [*bpy.data.cameras]
    with pytest.raises(ZeroDivisionError), stage([body_in_scene.mesh], 64):
        raise ZeroDivisionError
    assert ([*bpy.data.scenes], [*bpy.data.objects], [*bpy.data.cameras]) == before


def test_a_neutral_pose_hangs_the_arms_and_leaves_clip_and_pose_as_they_were(body_in_scene):
    armature, mesh = body_in_scene.armature, body_in_scene.mesh
    bones, scene = armature.pose.bones, bpy.context.scene
    bones["left_knee"].rotation_mode = "XYZ"
    bones["left_knee"].rotation_euler.x = 0.7
    armature.keyframe_insert("location", frame=1)
    action = armature.animation_data.action
    before = [bone.matrix_basis.copy() for bone in bones]
    with neutral(mesh):
        assert armature.animation_data.action is None
        for side, sign in (("left", 1), ("right", -1)):
            shoulder, wrist = bones[f"{side}_shoulder"].head, bones[f"{side}_wrist"].head
            assert shoulder.z - wrist.z > 0.35  # below, and a little aside
            assert 0.1 < sign * (wrist.x - shoulder.x) < 0.4
        assert bones["left_knee"].matrix_basis.to_euler().x == pytest.approx(0, abs=1e-6)
    assert armature.animation_data.action == action
    np.testing.assert_allclose([bone.matrix_basis for bone in bones], before, atol=1e-6)
    assert scene.frame_current == 1
