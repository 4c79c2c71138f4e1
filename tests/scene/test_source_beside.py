# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's own armature stands beside the body, moves, and goes again without a trace."""

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.bvh import read_bvh
from w2w.scene.base.actions import scene_rate
from w2w.scene.motion.source_beside import ASIDE, remove_source, show_source, source_collections

FILES = ["bvh/bandai_namco/dataset-1_walk_active_001.bvh", "mixamo/Conqster__TheBarMan/Walking.fbx"]


def timing():
    scene = bpy.context.scene
    return scene_rate(), scene.frame_start, scene.frame_end


def bone_heads(armature, frame):
    bpy.context.scene.frame_set(frame)
    return np.array([armature.matrix_world @ bone.head for bone in armature.pose.bones])


def with_z_up(path, folder):
    """A BVH file whose z axis is up, as some programs write them: its root turned, and moved so."""
    lines = path.read_text().splitlines()
    root = lines.index(next(line for line in lines if line.startswith("ROOT"))) + 3
    assert "Xposition Yposition Zposition" in lines[root]
    order = lines[root].split()[5:]
    first = lines.index(next(line for line in lines if line.startswith("Frame Time"))) + 1
    turn = Rotation.from_euler("x", 90, degrees=True)
    axes = "".join(name[0] for name in order)
    for number in range(first, len(lines)):
        if values := [float(value) for value in lines[number].split()]:
            values[:3] = turn.apply(values[:3])
            values[3:6] = (turn * Rotation.from_euler(axes, values[3:6], degrees=True)).as_euler(axes, True)
            lines[number] = " ".join(f"{value:.6f}" for value in values)
    turned = folder / "z_up.bvh"
    turned.write_text("\n".join(lines))
    return turned


def test_the_source_of_a_file_with_z_up_stands(body_in_scene, shared_data, tmp_path):
    path = with_z_up(shared_data / FILES[0], tmp_path)
    assert read_bvh(path).up == "z"
    show_source(body_in_scene.mesh, "walk", path, 0.01)
    (collection,) = source_collections("walk")
    armature = next(item for item in collection.objects if item.type == "ARMATURE")
    places = dict(zip((bone.name for bone in armature.pose.bones), bone_heads(armature, 6), strict=True))
    assert places["Head"][2] > 1.0
    assert abs(places["Foot_L"][2]) < 0.3
    remove_source("walk")


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
