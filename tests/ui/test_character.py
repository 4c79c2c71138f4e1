# SPDX-License-Identifier: GPL-3.0-or-later
"""A character of the scene shows the study of our body: map, sensors, what is chosen to be seen."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.scene.body.character import POINT
from w2w.scene.heatmap import heatmap_names
from w2w.scene.motion.takes import import_file
from w2w.ui.files import upkeep
from w2w.ui.study.lists import leading
from w2w.ui.study.state import current_body, patches_of

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender")

CHARACTER = "mixamo/fufroom__synthetic-echoes/Breathing Idle.fbx"
MANNEQUIN = "mixamo/fufroom__synthetic-echoes/Right Turn.fbx"


def bring(path: Path) -> bpy.types.Object:
    """Import a character and make its armature active."""
    before = set(bpy.data.objects)
    import_file(path)
    armature = next(item for item in set(bpy.data.objects) - before if item.type == "ARMATURE")
    bpy.context.view_layer.objects.active = armature
    return armature


def colours(mesh: bpy.types.Object) -> np.ndarray:
    values = np.empty(len(mesh.data.vertices) * 4, dtype=np.float32)
    mesh.data.color_attributes.active_color.data.foreach_get("color_srgb", values)
    return values.reshape(-1, 4)[:, :3]


@pytest.mark.slow
def test_a_finished_study_is_shown_on_it_and_follows_what_is_chosen(library: Path, shared_data: Path) -> None:
    body = make_study(library)
    armature = bring(shared_data / CHARACTER)
    (mesh,) = (item for item in bpy.context.scene.objects if item.find_armature() == armature)
    assert bpy.ops.w2w.use_character() == {"FINISHED"}
    assert heatmap_names(mesh) == heatmap_names(body)
    assert mesh.data.color_attributes.active_color.name == body.data.color_attributes.active_color.name
    mean = colours(mesh)
    body.w2w.view = "A1"
    assert mesh.data.color_attributes.active_color.name == body.data.color_attributes.active_color.name
    assert np.abs(colours(mesh) - mean).max() > 0.1
    marks = body.w2w.marks.objects
    wanted = [row.label for row in leading(body.w2w)]
    assert [mark.name.split(".")[0] for mark in marks] == wanted
    assert all(mark.parent == mesh for mark in marks)
    body.w2w.target = 1.0
    assert len(body.w2w.marks.objects) == len(body.w2w.chosen) > len(wanted) - 1
    bpy.ops.w2w.place_patches()
    assert not heatmap_names(mesh)
    assert body.w2w.marks is None
    bpy.ops.w2w.forget_character()
    assert POINT not in mesh.data.attributes
    assert body.w2w.character is None


def test_sensors_on_it_go_with_the_body_and_only_then(library: Path, shared_data: Path) -> None:
    body = make_study(library)
    bring(shared_data / CHARACTER)
    bpy.ops.w2w.use_character()
    name, balls = body.w2w.marks.name, {item.name for item in body.w2w.marks.objects}
    assert upkeep.take_along() is None
    assert balls <= {item.name for item in bpy.data.objects}
    with bpy.context.temp_override(selected_objects=[body]):
        bpy.ops.object.delete()
    assert upkeep.take_along() is None
    assert not balls & {item.name for item in bpy.data.objects}
    assert name not in bpy.data.collections
    assert any(item.type == "ARMATURE" for item in bpy.data.objects)


@pytest.mark.slow
def test_meshes_can_be_left_out(library: Path, shared_data: Path) -> None:
    body = make_study(library)
    bring(shared_data / MANNEQUIN)
    bpy.ops.w2w.use_character()
    joints, surface = (bpy.data.objects[name] for name in ("Beta_Joints", "Beta_Surface"))
    assert heatmap_names(joints)
    assert heatmap_names(surface)
    next(row for row in body.w2w.character_meshes if row.mesh == joints).use = False
    assert not heatmap_names(joints)
    assert heatmap_names(surface)
    assert {mark.parent for mark in body.w2w.marks.objects} == {surface}


@pytest.mark.slow
def test_without_a_body_ours_comes_in_its_proportions_beside_it(shared_data: Path) -> None:
    armature = bring(shared_data / MANNEQUIN)
    assert bpy.ops.w2w.use_character() == {"FINISHED"}
    body = current_body(bpy.context)
    assert body.w2w.character == armature
    assert body.w2w.has_shape
    assert (body.w2w.shape.arms, body.w2w.shape.legs) != (1.0, 1.0)
    assert body.parent.location.x > 0.5
    assert "2 meshes" in body.w2w.fit
    assert patches_of(body) is None


def test_what_is_no_character_is_refused_in_words(library: Path, shared_data: Path) -> None:
    make_study(library, "")
    assert not bpy.ops.w2w.use_character.poll()
    bring(shared_data / "mixamo/M3-org__CharacterStudio/AirSquat.fbx")
    with pytest.raises(RuntimeError, match="No mesh of the scene is moved by 'Armature'"):
        bpy.ops.w2w.use_character()


@pytest.mark.slow
def test_an_smpl_rig_in_its_own_spelling_becomes_the_body(shared_data: Path) -> None:
    armature = bring(shared_data / "smpl_body/fixture_smplbody_rigged.fbx")
    assert any(bone.name.startswith("m_avg_") for bone in armature.data.bones)
    mesh = next(item for item in bpy.data.objects if item.type == "MESH")
    bpy.context.view_layer.objects.active = mesh
    assert bpy.ops.w2w.use_mesh() == {"FINISHED"}
    body = current_body(bpy.context)
    assert body != mesh
    assert len(body.data.vertices) == 6890


def test_another_rig_is_told_of_use_character(shared_data: Path) -> None:
    bring(shared_data / CHARACTER)
    bpy.context.view_layer.objects.active = next(i for i in bpy.data.objects if i.type == "MESH")
    with pytest.raises(RuntimeError, match="press Use Character"):
        bpy.ops.w2w.use_mesh()
