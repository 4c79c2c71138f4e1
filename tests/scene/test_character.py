# SPDX-License-Identifier: GPL-3.0-or-later
"""Real characters, as Blender's importer brings them, carry our map and our sensors."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from w2w.core.body.body import JOINT_INDEX
from w2w.core.patches.correspondence import PARTS
from w2w.scene.base.body import add_body, rest_vertices
from w2w.scene.body.character import (
    MARK,
    POINT,
    carry_heatmaps,
    character_meshes,
    place_marks,
    read_character,
    tie,
    untie,
)
from w2w.scene.heatmap import heatmap_names, paint_colours
from w2w.scene.motion.takes import import_file

pytestmark = pytest.mark.usefixtures("empty_file")

CHARACTERS = {
    "fufroom__synthetic-echoes/Right Turn.fbx": 2,
    "fufroom__synthetic-echoes/Breathing Idle.fbx": 1,
    "EpicNicks__VectorheartGame/Great Sword High Spin Attack (4).fbx": 1,
    "s4ru__Projecto-Visualizacion/Digging.fbx": 1,
}
"""Files with a skin, and their meshes: from 25,000 vertices in pieces to 246 in all."""


TORN = "s4ru__Projecto-Visualizacion/Digging.fbx"
"""Blender's importer before 4.5 makes its bones 100 times as large as its skin."""


def imported(shared_data, file):
    import_file(shared_data / "mixamo" / file)
    armature = next(item for item in bpy.data.objects if item.type == "ARMATURE")
    return armature, character_meshes(armature, bpy.context.scene)


def coloured(body):
    """A body whose heatmap is where each vertex is: red to its left, green back, blue up."""
    objects = add_body(body)
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    paint_colours(objects.mesh.data, "Expected F1", (body.vertices - low) / (high - low))
    return objects.mesh


def colours(mesh):
    values = np.empty(len(mesh.data.vertices) * 4, dtype=np.float32)
    mesh.data.color_attributes["Expected F1"].data.foreach_get("color_srgb", values)
    return values.reshape(-1, 4)[:, :3]


@pytest.mark.parametrize("file", CHARACTERS)
def test_the_map_of_our_body_is_painted_on_the_parts_it_is_of(shared_data, bundled_body, file):
    armature, meshes = imported(shared_data, file)
    assert len(meshes) == CHARACTERS[file]
    if file == TORN and bpy.app.version < (4, 5):
        with pytest.raises(ValueError, match="Its bones lie far from the skin"):
            read_character(armature, meshes)
        return
    figure = read_character(armature, meshes)
    assert tie(figure, meshes, bundled_body) < 0.03
    body = coloured(bundled_body)
    start = 0
    for mesh in meshes:
        carry_heatmaps(body, mesh)
        assert heatmap_names(mesh) == ["Expected F1"]
        part = PARTS[figure.weights[start : start + len(mesh.data.vertices)].argmax(axis=1)]
        start += len(mesh.data.vertices)
        shown = colours(mesh)
        for name, axis, sign in (
            ("left_elbow", 0, 1),
            ("right_elbow", 0, -1),
            ("head", 2, 1),
            ("left_ankle", 2, -1),
        ):
            own = shown[part == JOINT_INDEX[name]][:, axis]
            whole = (bundled_body.vertices[:, axis] - bundled_body.vertices[:, axis].min()) / np.ptp(
                bundled_body.vertices[:, axis]
            )
            truth = whole[PARTS[bundled_body.weights.argmax(axis=1)] == JOINT_INDEX[name]]
            if len(own):
                assert truth.min() - 0.03 < np.median(own) < truth.max() + 0.03
                assert sign * (np.median(own) - 0.5) > 0.1
        untie(mesh)
        assert not heatmap_names(mesh)
        assert POINT not in mesh.data.attributes


@pytest.mark.slow
def test_sensors_sit_on_its_skin_and_follow_its_own_animation(shared_data, bundled_body):
    armature, meshes = imported(shared_data, "fufroom__synthetic-echoes/Right Turn.fbx")
    tie(read_character(armature, meshes), meshes, bundled_body)
    body = add_body(bundled_body).mesh
    wrist = int(np.argmax(bundled_body.weights[:, JOINT_INDEX["left_wrist"]]))
    knee = int(np.argmax(bundled_body.weights[:, JOINT_INDEX["right_knee"]]))
    marks = place_marks(body, [wrist, knee], meshes, 0.02)
    for mark in marks:
        bpy.context.scene.collection.objects.link(mark)
    bones = {bone.name.split(":")[-1]: bone for bone in armature.pose.bones}
    for frame in (1, 12, 20):
        bpy.context.scene.frame_set(frame)
        for mark, bone in zip(marks, ("LeftHand", "RightLeg"), strict=True):
            place, joint = mark.matrix_world.translation, armature.matrix_world @ bones[bone].head
            height = np.ptp([(armature.matrix_world @ bone.head).z for bone in armature.pose.bones])
            assert (place - joint).length < 0.25 * height
            evaluated = mark.parent.evaluated_get(bpy.context.evaluated_depsgraph_get())
            points = rest_vertices(evaluated) @ np.array(evaluated.matrix_world)[:3, :3].T
            points += np.array(evaluated.matrix_world)[:3, 3]
            assert np.linalg.norm(points - np.array(place), axis=1).min() < 0.01 * height
    assert all(MARK not in mark for mark in marks)


@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_a_skeleton_of_another_size_than_its_skin_is_refused(bundled_body, scale):
    objects = add_body(bundled_body)
    objects.mesh.data.transform(Matrix.Scale(scale, 4))
    with pytest.raises(ValueError, match="Its bones lie far from the skin"):
        read_character(objects.armature, [objects.mesh])


def test_a_mesh_that_lost_its_tie_or_is_of_another_body_is_refused_in_words(shared_data, bundled_body):
    armature, meshes = imported(shared_data, "fufroom__synthetic-echoes/Breathing Idle.fbx")
    body = coloured(bundled_body)
    with pytest.raises(ValueError, match="has lost what ties it to the body"):
        carry_heatmaps(body, meshes[0])
    tie(read_character(armature, meshes), meshes, bundled_body)
    small = bpy.data.meshes.new("small")
    small.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    other = bpy.data.objects.new("small", small)
    paint_colours(small, "Expected F1", np.zeros((3, 3)))
    with pytest.raises(ValueError, match="is tied to another body"):
        carry_heatmaps(other, meshes[0])


def test_a_mesh_that_hangs_at_a_bone_is_of_that_bone_s_part(bundled_body):
    objects = add_body(bundled_body)
    ball = bpy.data.meshes.new("watch")
    place = bundled_body.joints[JOINT_INDEX["left_wrist"]] + [0, 0, 0.03]
    ball.from_pydata([place, place + [0.01, 0, 0], place + [0, 0.01, 0]], [], [(0, 1, 2)])
    watch = bpy.data.objects.new("watch", ball)
    bpy.context.scene.collection.objects.link(watch)
    watch.parent, watch.parent_type, watch.parent_bone = objects.armature, "BONE", "left_wrist"
    watch.matrix_parent_inverse = (
        objects.armature.matrix_world @ objects.armature.pose.bones["left_wrist"].matrix
    ).inverted()
    bpy.context.view_layer.update()
    assert set(character_meshes(objects.armature, bpy.context.scene)) == {objects.mesh, watch}
    figure = read_character(objects.armature, [watch])
    assert (figure.weights.argmax(axis=1) == JOINT_INDEX["left_wrist"]).all()


def test_of_layers_the_outer_one_carries_the_sensor(bundled_body):
    objects = add_body(bundled_body)
    inner = objects.mesh.copy()
    inner.data = objects.mesh.data.copy()
    bpy.context.scene.collection.objects.link(inner)
    shrunk = bundled_body.vertices - 0.003 * bundled_body.vertex_normals
    inner.data.vertices.foreach_set("co", shrunk.astype(np.float32).ravel())
    meshes = [inner, objects.mesh]
    tie(read_character(objects.armature, meshes), meshes, bundled_body)
    vertices = list(range(0, len(bundled_body.vertices), 700))
    assert {mark.parent for mark in place_marks(objects.mesh, vertices, meshes, 0.02)} == {objects.mesh}
