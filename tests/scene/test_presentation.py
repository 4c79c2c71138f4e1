# SPDX-License-Identifier: GPL-3.0-or-later
"""The way a body faces, by which its picture is taken from the front."""

import bpy
import numpy as np
import pytest

from w2w.scene.heatmap import paint_colours, show_heatmap
from w2w.scene.presentation import CLOTH, facing, posed, shown_surface


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


def test_a_surface_is_as_posed_and_painted_and_a_garment_has_a_colour_of_cloth(body_in_scene):
    mesh, armature = body_in_scene.mesh, body_in_scene.armature
    armature.location.x = 0.5
    colours = np.linspace(0, 1, 3 * len(mesh.data.vertices)).reshape(-1, 3)
    paint_colours(mesh.data, "map", colours)
    show_heatmap(mesh, "map")
    shirt = bpy.data.objects.new("shirt", bpy.data.meshes.new("shirt"))
    shirt.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    bpy.context.scene.collection.objects.link(shirt)
    with posed(mesh):
        points, faces, painted = shown_surface([mesh, shirt])
    n_body = len(colours)
    assert points[:n_body, 0].mean() == pytest.approx(0.5, abs=0.02)
    assert np.ptp(points[:n_body, 0]) < 1.2  # the arms hang
    np.testing.assert_allclose(painted[:n_body], colours, atol=0.01)
    np.testing.assert_allclose(painted[n_body:], [CLOTH] * 3)
    assert faces[-1].tolist() == [n_body, n_body + 1, n_body + 2]
    assert faces.max() < len(points)


def test_a_neutral_pose_hangs_the_arms_and_leaves_clip_and_pose_as_they_were(body_in_scene):
    armature, mesh = body_in_scene.armature, body_in_scene.mesh
    bones, scene = armature.pose.bones, bpy.context.scene
    bones["left_knee"].rotation_mode = "XYZ"
    bones["left_knee"].rotation_euler.x = 0.7
    armature.keyframe_insert("location", frame=1)
    action = armature.animation_data.action
    before = [bone.matrix_basis.copy() for bone in bones]
    with posed(mesh):
        assert armature.animation_data.action is None
        for side, sign in (("left", 1), ("right", -1)):
            shoulder, wrist = bones[f"{side}_shoulder"].head, bones[f"{side}_wrist"].head
            assert shoulder.z - wrist.z > 0.35  # below, and a little aside
            assert 0.1 < sign * (wrist.x - shoulder.x) < 0.4
        assert bones["left_knee"].matrix_basis.to_euler().x == pytest.approx(0, abs=1e-6)
    assert armature.animation_data.action == action
    np.testing.assert_allclose([bone.matrix_basis for bone in bones], before, atol=1e-6)
    assert scene.frame_current == 1
