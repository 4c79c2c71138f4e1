# SPDX-License-Identifier: GPL-3.0-or-later
"""Both ways to bake agree with Blender's own empties, and the right one is taken."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from w2w.core.motion.motion import Motion
from w2w.core.retargeting.retarget import retarget
from w2w.scene.bake import PatchBaker
from w2w.scene.base import actions
from w2w.scene.base.actions import bone_curves, frames_of, show_action, write_action
from w2w.scene.base.patches import patch_empties, place_patches
from w2w.scene.motion.takes import read_clip

from .conftest import bake, difference, read_empties

MAX_DISTANCE = 1e-5
MAX_ANGLE = 0.01


@pytest.fixture
def waving(waving):
    """Its first 24 frames."""
    return replace(waving, rotations=waving.rotations[:24], pelvis=waving.pelvis[:24])


def play(objects, motion):
    action = write_action(objects.armature, motion)
    show_action(objects.armature, action)
    return action


def assert_agree(matrices, truth):
    distance, angle = difference(matrices, truth)
    assert distance < MAX_DISTANCE
    assert angle < MAX_ANGLE


def naive(objects, patches, action):
    frames, _ = frames_of(action, bone_curves(objects.armature, action))
    return read_empties(patch_empties(place_patches(objects.mesh, patches)), frames)


@pytest.mark.parametrize("scene_rate", [30, 24])
def test_fast_general_and_the_empties_agree(body_in_scene, patches, waving, scene_rate):
    bpy.context.scene.render.fps = scene_rate
    action = play(body_in_scene, waving)
    fast = bake(body_in_scene.mesh, patches)
    general = bake(body_in_scene.mesh, patches, path="general")
    truth = naive(body_in_scene, patches, action)
    assert (fast.path, general.path) == ("fast", "general")
    assert fast.matrices.shape == (24, len(patches), 4, 4)
    assert fast.rate == pytest.approx(30, rel=1e-5)
    assert general.rate == pytest.approx(30, rel=1e-5)
    assert_agree(fast.matrices, truth)
    assert_agree(general.matrices, truth)
    assert_agree(fast.matrices, general.matrices)


@pytest.mark.slow
@pytest.mark.parametrize(
    "file",
    [
        "M3-org__CharacterStudio/AirSquat.fbx",
        "GDDMN__Test_DigitalOxygen/Roundhouse Kick.fbx",
        "eminkarakaya__Idle-Restaurant/Sit To Stand.fbx",
    ],
)
def test_they_agree_on_real_clips_and_all_patches(
    body_in_scene, bundled_body, all_patches, shared_data, file
):
    motion = retarget(read_clip(shared_data / "mixamo" / file), bundled_body).motion
    thinned = Motion(motion.rotations[::4], motion.pelvis[::4], motion.rate / 4)
    action = play(body_in_scene, thinned)
    fast, general = (bake(body_in_scene.mesh, all_patches, path=path) for path in ("auto", "general"))
    truth = naive(body_in_scene, all_patches, action)
    assert fast.path == "fast"
    assert_agree(fast.matrices, truth)
    assert_agree(general.matrices, truth)


def test_a_body_put_elsewhere_is_still_fast(body_in_scene, patches, waving):
    body_in_scene.armature.matrix_world = Matrix.Translation((1, -2, 0)) @ Matrix.Rotation(0.8, 4, "Z")
    bpy.context.view_layer.update()
    action = play(body_in_scene, waving)
    fast = bake(body_in_scene.mesh, patches)
    assert fast.path == "fast"
    assert_agree(fast.matrices, naive(body_in_scene, patches, action))


def test_a_scaled_body_is_still_fast(body_in_scene, patches, waving):
    body_in_scene.armature.scale = (1.2, 1.2, 1.2)
    bpy.context.view_layer.update()
    action = play(body_in_scene, waving)
    fast = bake(body_in_scene.mesh, patches)
    truth = naive(body_in_scene, patches, action)
    truth[..., :3, :3] /= np.linalg.norm(truth[..., :3, :3], axis=-2, keepdims=True)
    assert fast.path == "fast"
    assert_agree(fast.matrices, truth)


def add_constraint(objects):
    target = bpy.data.objects.new("target", None)
    bpy.context.scene.collection.objects.link(target)
    target.location = (0.3, -0.5, 1.2)
    constraint = objects.armature.pose.bones["left_wrist"].constraints.new("IK")
    constraint.target, constraint.chain_count = target, 3


def add_bone_driver(objects):
    curve = objects.armature.driver_add('pose.bones["left_elbow"].rotation_quaternion', 1)
    curve.driver.type = "SCRIPTED"
    curve.driver.expression = "0.02 * frame"


def add_object_animation(objects):
    objects.mesh.location.x = 0
    objects.mesh.keyframe_insert("location", frame=1)
    objects.mesh.location.x = 1
    objects.mesh.keyframe_insert("location", frame=40)


def add_shape_key(objects):
    objects.mesh.shape_key_add(name="Basis")
    key = objects.mesh.shape_key_add(name="Wide")
    for point in key.points:
        point.co.x *= 1.2
    key.value = 0.7


def add_smooth_modifier(objects):
    objects.mesh.modifiers.new("Smooth", "SMOOTH").iterations = 3


def add_volume_preservation(objects):
    objects.mesh.modifiers["Armature"].use_deform_preserve_volume = True


def add_nla_strip(objects):
    data = objects.armature.animation_data
    data.nla_tracks.new().strips.new("waving", 11, data.action)
    data.action = None
    bpy.context.scene.frame_end = 24


def add_object_curve(objects):
    objects.armature.location = (0, 0, 0)
    objects.armature.keyframe_insert("location", frame=1)
    objects.armature.location = (0.5, 0, 0)
    objects.armature.keyframe_insert("location", frame=30)


def move_a_bone_off_its_joint(objects):
    bone = objects.armature.pose.bones["left_elbow"]
    bone.location = (0.0, 0.05, 0.0)
    bone.keyframe_insert("location", frame=1)


def bend_a_bone(objects):
    objects.armature.data.bones["spine2"].bbone_segments = 4
    objects.armature.pose.bones["spine2"].bbone_curveinz = 0.2


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (add_constraint, "constraints"),
        (add_bone_driver, "drivers"),
        (add_object_animation, "is animated"),
        (add_shape_key, "shape keys"),
        (add_smooth_modifier, "Smooth"),
        (add_volume_preservation, "linear blend skinning"),
        (add_nla_strip, "NLA"),
        (add_object_curve, "as a whole"),
        (move_a_bone_off_its_joint, "left_elbow"),
        (bend_a_bone, "spine2"),
    ],
)
def test_what_else_moves_the_body_takes_the_general_path(body_in_scene, patches, waving, change, word):
    bpy.context.scene.render.fps = 30
    action = play(body_in_scene, waving)
    plain = bake(body_in_scene.mesh, patches)
    change(body_in_scene)
    result = bake(body_in_scene.mesh, patches)
    assert result.path == "general"
    assert word in result.reason
    assert_agree(result.matrices, naive(body_in_scene, patches, action))
    # without this the general path might be needless, and the test blind
    assert difference(result.matrices, plain.matrices)[0] > 1e-3


def add_subdivision(mesh):
    mesh.modifiers.new("Subdivision", "SUBSURF").levels = 1


def add_solidify(mesh):
    modifier = mesh.modifiers.new("Solidify", "SOLIDIFY")
    modifier.thickness, modifier.offset = 0.01, 1


def add_edge_split(mesh):
    mesh.modifiers.new("Edge Split", "EDGE_SPLIT").split_angle = 0.02  # nearly every vertex in copies


@pytest.mark.parametrize(
    ("change", "n_frames"),
    [pytest.param(add_subdivision, 2, marks=pytest.mark.slow), (add_solidify, 4)]
    + [pytest.param(add_edge_split, 4, marks=pytest.mark.slow)],
)
def test_modifiers_that_add_vertices_are_followed(body_in_scene, patches, waving, change, n_frames):
    some = replace(patches, triangles=patches.triangles[:5], vertices=patches.vertices[:5])
    some = replace(some, regions=patches.regions[:5])
    action = play(body_in_scene, Motion(waving.rotations[:n_frames], waving.pelvis[:n_frames], 24.0))
    change(body_in_scene.mesh)
    result = bake(body_in_scene.mesh, some)
    assert result.path == "general"
    assert_agree(result.matrices, naive(body_in_scene, some, action))
    assert "W2W vertex tag" not in body_in_scene.mesh.data.attributes


def test_a_modifier_that_removes_patches_is_refused(body_in_scene, patches, waving):
    play(body_in_scene, waving)
    modifier = body_in_scene.mesh.modifiers.new("Mask", "MASK")
    modifier.vertex_group = "head"
    with pytest.raises(ValueError, match=r"remove \d+ of the vertices under patches"):
        bake(body_in_scene.mesh, patches)
    assert "W2W vertex tag" not in body_in_scene.mesh.data.attributes


@pytest.mark.parametrize("state", ["hidden", "idle shape key", "muted constraint"])
def test_what_does_not_move_the_body_stays_fast(body_in_scene, patches, waving, state):
    play(body_in_scene, waving)
    if state == "hidden":
        body_in_scene.mesh.modifiers.new("Smooth", "SMOOTH").show_viewport = False
    elif state == "idle shape key":
        add_shape_key(body_in_scene)
        body_in_scene.mesh.data.shape_keys.key_blocks["Wide"].value = 0
    else:
        add_constraint(body_in_scene)
        body_in_scene.armature.pose.bones["left_wrist"].constraints[0].mute = True
    result = bake(body_in_scene.mesh, patches)
    assert result.path == "fast"
    assert_agree(result.matrices, bake(body_in_scene.mesh, patches, path="general").matrices)


def test_without_an_action_the_scene_s_frames_are_baked(body_in_scene, patches):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 5, 9
    result = bake(body_in_scene.mesh, patches)
    assert result.path == "general"
    assert "no action" in result.reason
    assert result.matrices.shape == (5, len(patches), 4, 4)


def test_another_action_is_baked_and_the_scene_left_as_it_was(body_in_scene, patches, waving):
    scene = bpy.context.scene
    played = play(body_in_scene, waving)
    other = write_action(body_in_scene.armature, Motion(waving.rotations[::-1], waving.pelvis[::-1], 30.0))
    collection = place_patches(body_in_scene.mesh, patches)
    scene.frame_set(7)
    fast, general = (
        bake(body_in_scene.mesh, patches, action=other, path=path) for path in ("auto", "general")
    )
    assert_agree(fast.matrices, general.matrices)
    assert_agree(fast.matrices[::-1], bake(body_in_scene.mesh, patches).matrices)
    assert body_in_scene.armature.animation_data.action == played
    assert scene.frame_current == 7
    assert not bpy.context.view_layer.layer_collection.children[collection.name].exclude


def test_a_cancelled_bake_leaves_the_scene_as_it_was(body_in_scene, patches, waving, monkeypatch):
    scene = bpy.context.scene
    played = play(body_in_scene, waving)
    other = write_action(body_in_scene.armature, waving)
    collection = place_patches(body_in_scene.mesh, patches)
    scene.frame_set(7)
    empties = list(collection.objects)
    empties[3].select_set(True)
    empties[4].hide_set(True)
    bpy.context.view_layer.objects.active = empties[3]
    monkeypatch.setattr("w2w.scene.bake.why_not_fast", lambda *_: "asked for")
    frames = PatchBaker(body_in_scene.mesh, patches).by_frame(other)
    assert [next(frames) for _ in range(3)] == pytest.approx([1 / 24, 2 / 24, 3 / 24])
    assert scene.frame_current != 7
    frames.close()
    assert body_in_scene.armature.animation_data.action == played
    assert scene.frame_current == 7
    assert not bpy.context.view_layer.layer_collection.children[collection.name].exclude
    assert bpy.context.view_layer.objects.active == empties[3]
    assert [item for item in bpy.context.selected_objects if item in empties] == [empties[3]]
    assert [item for item in empties if item.hide_get()] == [empties[4]]


def test_a_mirrored_or_uneven_body_is_refused(body_in_scene, patches):
    for scale in ((1, 1, 2), (-1, 1, 1)):
        body_in_scene.armature.scale = scale
        bpy.context.view_layer.update()
        with pytest.raises(ValueError, match="apply its scale"):
            PatchBaker(body_in_scene.mesh, patches)


def test_a_bake_returns_the_motion_it_read(body_in_scene, patches, waving, monkeypatch):
    body_in_scene.armature.location.x = 2.0
    bpy.context.view_layer.update()
    play(body_in_scene, waving)
    read, times = actions.read_action, []
    monkeypatch.setattr(actions, "read_action", lambda *given: times.append(1) or read(*given))
    for path in ("auto", "general"):
        baked = bake(body_in_scene.mesh, patches, path=path)
        np.testing.assert_allclose(baked.motion.rotations, waving.rotations, atol=1e-5)
        np.testing.assert_allclose(baked.motion.pelvis, waving.pelvis, atol=1e-5)
    assert len(times) == 2


def test_a_bake_of_what_no_motion_tells_returns_none(body_in_scene, patches, waving):
    play(body_in_scene, waving)
    body_in_scene.armature.pose.bones["left_knee"].scale = (1.5, 1.5, 1.5)
    body_in_scene.armature.pose.bones["left_knee"].keyframe_insert("scale", frame=1)
    baked = bake(body_in_scene.mesh, patches)
    assert (baked.path, baked.motion) == ("general", None)
    assert "scales the bone 'left_knee'" in baked.reason
    body_in_scene.armature.animation_data.action = None
    assert bake(body_in_scene.mesh, patches).motion is None
