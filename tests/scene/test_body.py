# SPDX-License-Identifier: GPL-3.0-or-later
"""A body in the scene: the same body comes back, and Blender skins it as we do."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from w2w.core.body.body import JOINT_NAMES, PARENTS
from w2w.core.motion.skinning import skin, skinning_transforms
from w2w.scene.base.actions import show_action, write_action
from w2w.scene.base.body import add_body, armature_of, body_of


def assert_same_body(read, body, atol=1e-6):
    np.testing.assert_allclose(read.vertices, body.vertices, atol=atol)
    np.testing.assert_allclose(read.joints, body.joints, atol=atol)
    np.testing.assert_allclose(read.weights, body.weights, atol=atol)
    np.testing.assert_array_equal(read.faces, body.faces)


def test_the_body_comes_back(body_in_scene, bundled_body):
    read = body_of(body_in_scene.mesh)
    assert_same_body(read, bundled_body)
    np.testing.assert_array_equal(read.mirror, bundled_body.mirror)


def test_where_the_armature_stands_is_no_property_of_the_body(body_in_scene, bundled_body):
    body_in_scene.armature.matrix_world = Matrix.Translation((3, -2, 1)) @ Matrix.Rotation(0.7, 4, "Z")
    bpy.context.view_layer.update()
    assert_same_body(body_of(body_in_scene.mesh), bundled_body)


def test_a_scaled_armature_scales_the_body(body_in_scene, bundled_body):
    body_in_scene.armature.scale = (0.5, 0.5, 0.5)
    bpy.context.view_layer.update()
    read = body_of(body_in_scene.mesh)
    np.testing.assert_allclose(read.vertices, bundled_body.vertices * 0.5, atol=1e-6)
    np.testing.assert_allclose(read.joints, bundled_body.joints * 0.5, atol=1e-6)


def test_bones_are_the_joints(body_in_scene):
    bones = body_in_scene.armature.data.bones
    assert {bone.name for bone in bones} == set(JOINT_NAMES)
    for joint, name in enumerate(JOINT_NAMES):
        parent = bones[name].parent
        assert (parent.name if parent else None) == (JOINT_NAMES[PARENTS[joint]] if joint else None)
        axes = np.array(bones[name].matrix_local, dtype=np.float64)[:3, :3]
        # bones against their parent's direction lose digits: 1.5e-5 where the pelvis pointed straight up
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-5, err_msg=name)


def test_blender_skins_the_mesh_as_we_do(body_in_scene, bundled_body, waving):
    mesh, armature = body_in_scene
    bpy.context.scene.render.fps = 30
    show_action(armature, write_action(armature, waving))
    frames = [0, 17, 59]
    ours = skin(bundled_body, skinning_transforms(bundled_body, waving)[frames])
    for frame, expected in zip(frames, ours, strict=True):
        bpy.context.scene.frame_set(frame + 1)
        evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
        posed = np.array([evaluated.matrix_world @ vertex.co for vertex in evaluated.data.vertices])
        np.testing.assert_allclose(posed, expected, atol=2e-6)


@pytest.mark.usefixtures("empty_file")
def test_adding_a_body_leaves_selection_and_active_object(bundled_body):
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.active_object
    add_body(bundled_body)
    assert bpy.context.view_layer.objects.active == cube
    assert bpy.context.selected_objects == [cube]
    assert bpy.context.mode == "OBJECT"


@pytest.mark.usefixtures("empty_file")
def test_two_bodies_in_one_file_keep_apart(bundled_body):
    first, second = add_body(bundled_body), add_body(bundled_body)
    assert armature_of(first.mesh) == first.armature
    assert armature_of(second.mesh) == second.armature
    assert first.mesh.data != second.mesh.data


def test_what_is_no_body_is_refused_with_a_reason(body_in_scene):
    mesh, armature = body_in_scene
    with pytest.raises(ValueError, match="is not a mesh"):
        armature_of(armature)
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(ValueError, match="no armature modifier"):
        body_of(bpy.context.active_object)
    mesh.vertex_groups.remove(mesh.vertex_groups["head"])
    with pytest.raises(ValueError, match="follow none of the 24 bones"):
        body_of(mesh)
    armature.data.bones["left_knee"].name = "knee"
    with pytest.raises(ValueError, match="lacks the bones left_knee"):
        body_of(mesh)
