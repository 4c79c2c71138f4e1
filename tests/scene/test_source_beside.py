# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's own armature stands beside the body, moves, and goes again without a trace."""

import bpy
import numpy as np
import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.scene.base.actions import scene_rate
from w2w.scene.motion.source_beside import ASIDE, remove_source, show_source, source_collections

FILES = ["bvh/bandai_namco/dataset-1_walk_active_001.bvh", "mixamo/Conqster__TheBarMan/Walking.fbx"]


def timing():
    scene = bpy.context.scene
    return scene_rate(), scene.frame_start, scene.frame_end


def bone_heads(armature, frame):
    bpy.context.scene.frame_set(frame)
    return np.array([armature.matrix_world @ bone.head for bone in armature.pose.bones])


@pytest.mark.parametrize("file", FILES)
def test_it_stands_beside_the_body_and_moves_and_nothing_else_changes(body_in_scene, shared_data, file):
    body_in_scene.mesh.select_set(True)
    bpy.context.view_layer.objects.active = body_in_scene.mesh
    before = set(bpy.data.objects), set(bpy.data.actions), timing()
    show_source(body_in_scene.mesh, "walk", shared_data / file, 1.0)
    (collection,) = source_collections("walk")
    armature = next(item for item in collection.objects if item.type == "ARMATURE")
    stand = next(item for item in collection.objects if item.type == "EMPTY" and item.parent is None)
    assert stand.location.x == pytest.approx(ASIDE)
    assert armature.parent == stand
    assert np.ptp([bone_heads(armature, frame) for frame in (1, 6, 12)], axis=0).max() > 0.05
    places = dict(zip((bone.name for bone in armature.pose.bones), bone_heads(armature, 6), strict=True))
    head = next(place for name, place in places.items() if name.lower().endswith("head"))
    trunk = head - np.mean([place for name, place in places.items() if "foot" in name.lower()], axis=0)
    assert trunk[2] > 2 * np.hypot(*trunk[:2])  # it stands, whichever axis is up in the file
    assert timing() == before[2]
    assert bpy.context.selected_objects == [body_in_scene.mesh]
    assert bpy.context.view_layer.objects.active == body_in_scene.mesh
    remove_source("walk")
    assert not source_collections()
    assert (set(bpy.data.objects), set(bpy.data.actions)) == before[:2]


def test_a_file_that_cannot_be_read_leaves_nothing(body_in_scene, tmp_path):
    (tmp_path / "bad.bvh").write_text("HIERARCHY")
    with pytest.raises(UnusableMotion):
        show_source(body_in_scene.mesh, "bad", tmp_path / "bad.bvh", 1.0)
    assert not source_collections()
