# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters on the rigs of other tools carry our map: each vertex finds itself on our body."""

from __future__ import annotations

import addon_utils
import bpy
import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.body.skeleton import JOINT_NAMES
from w2w.core.motion.bone_maps import best_match, missing_joints
from w2w.core.motion.source import UnusableMotion
from w2w.scene.character import POINT, character_meshes, read_character, tie

from .other_rigs import RIGS, add_rigged, add_skin, end_of

pytestmark = pytest.mark.usefixtures("empty_file")

NEAR = 0.03
"""Median distance of a vertex from itself on our body, metres: the surface is laid on it by joints alone."""


def distance_from_itself(body: Body, mesh: bpy.types.Object) -> np.ndarray:
    """How far each vertex of a skin of ours is from where it was laid, metres."""
    values = np.empty(len(mesh.data.vertices) * 3, dtype=np.float32)
    mesh.data.attributes[POINT].data.foreach_get("vector", values)
    face, first, second = values.reshape(-1, 3).T
    corners = body.vertices[body.faces[face.astype(int)]]
    shares = np.stack([first, second, 1 - first - second], axis=1)
    return np.linalg.norm(np.einsum("vc,vca->va", shares, corners) - body.vertices, axis=1)


@pytest.mark.parametrize("rig", RIGS)
def test_a_skin_of_ours_finds_itself(rig: str, bundled_body: Body) -> None:
    armature, mesh = add_rigged(bundled_body, RIGS[rig])
    bones = [bone.name for bone in armature.data.bones]
    bone_map, matched = best_match(bones)
    assert not missing_joints(matched), bone_map.name
    assert bone_map.name.split()[0] in rig.replace("VRoid", "VRM")
    of = {bone.name: bone for bone in RIGS[rig]}
    for joint, bone in matched.items():
        assert of[bones[bone]].joint.strip("123") == JOINT_NAMES[joint].strip("123")
        assert of[bones[bone]].shares
    assert character_meshes(armature, bpy.context.scene) == [mesh]
    figure = read_character(armature, [mesh])
    assert tie(figure, [mesh], bundled_body) < 1e-3
    assert np.median(distance_from_itself(bundled_body, mesh)) < NEAR


def fit_metarig(metarig: bpy.types.Object, body: Body) -> None:
    """Move the bones of Rigify's human to the joints of a body, each with what hangs on it."""
    _, matched = best_match([bone.name for bone in metarig.data.bones])
    joint_of = {metarig.data.bones[bone].name: joint for joint, bone in matched.items()}
    bpy.ops.object.mode_set(mode="EDIT")
    bones = metarig.data.edit_bones
    before = {bone.name: bone.head.copy() for bone in bones}
    for bone in bones:
        carrier = bone
        while carrier.name not in joint_of and carrier.parent is not None:
            carrier = carrier.parent
        joint = joint_of.get(carrier.name, 0)
        move = type(bone.head)(body.joints[joint]) - before[carrier.name]
        if bone.name in joint_of:
            bone.head = body.joints[joint]
            if not bone.children or not bone.children[0].use_connect:
                bone.tail = end_of(body, joint)
        elif not bone.use_connect:
            bone.head, bone.tail = before[bone.name] + move, bone.tail + move
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.slow
def test_a_character_on_a_rig_that_rigify_made_finds_itself(bundled_body: Body) -> None:
    if addon_utils.enable("rigify") is None:
        pytest.skip("this Blender comes without Rigify")
    bpy.ops.object.armature_human_metarig_add()
    metarig = bpy.context.object
    fit_metarig(metarig, bundled_body)
    bpy.context.view_layer.objects.active = metarig
    bpy.ops.object.mode_set(mode="POSE")
    assert bpy.ops.pose.rigify_generate() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    rig = bpy.data.objects["rig"]
    bones = [bone.name for bone in rig.data.bones]
    bone_map, matched = best_match(bones)
    assert bone_map.name == "Rigify"
    assert len(matched) == len(JOINT_NAMES)
    assert all(bones[bone].startswith("DEF-") for bone in matched.values())
    joint_of = {bones[bone]: JOINT_NAMES[joint] for joint, bone in matched.items()}
    joint_of |= {
        f"{bone}.001": joint
        for bone, joint in joint_of.items()
        if f"{bone}.001" in bones and "spine" not in bone
    }
    mesh = add_skin(bundled_body, rig, joint_of)
    assert tie(read_character(rig, [mesh]), [mesh], bundled_body) < 0.01
    assert np.median(distance_from_itself(bundled_body, mesh)) < NEAR


def test_a_rig_that_is_not_understood_is_told_which_bones_are_missing(bundled_body: Body) -> None:
    bones = [bone for bone in RIGS["Unreal 4"] if bone.joint not in ("left_knee", "left_ankle", "left_foot")]
    armature, mesh = add_rigged(bundled_body, bones)
    with pytest.raises(UnusableMotion, match=r"left[ _]knee.*left[ _]ankle"):
        read_character(armature, [mesh])
