# SPDX-License-Identifier: GPL-3.0-or-later
"""Empties on the body: each sits in the frame of its triangle and rides on it without scripts."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import patch_matrices
from w2w.scene.base.actions import show_action, write_action
from w2w.scene.base.body import add_body
from w2w.scene.base.patches import (
    patch_empties,
    place_patches,
    remove_patches,
)

from .conftest import difference, read_empties


def rest(body):
    return Motion(np.eye(3) * np.ones((1, 24, 1, 1)), body.joints[:1], 24.0)


def test_every_empty_is_in_the_frame_of_its_triangle(body_in_scene, bundled_body, all_patches):
    empties = patch_empties(place_patches(body_in_scene.mesh, all_patches))
    truth = patch_matrices(bundled_body, all_patches.triangles, rest(bundled_body))
    distance, angle = difference(read_empties(empties, np.array([1.0])), truth)
    assert len(empties) == 512
    assert distance < 1e-6
    assert angle < 0.01


def test_the_empties_ride_on_the_moving_body(body_in_scene, bundled_body, patches, waving):
    bpy.context.scene.render.fps = 30
    empties = patch_empties(place_patches(body_in_scene.mesh, patches))
    show_action(body_in_scene.armature, write_action(body_in_scene.armature, waving))
    truth = patch_matrices(bundled_body, patches.triangles, waving)
    distance, angle = difference(read_empties(empties, 1.0 + np.arange(60)), truth)
    assert distance < 1e-5
    assert angle < 0.01


def test_they_follow_when_the_body_is_put_elsewhere(body_in_scene, bundled_body, patches):
    place = Matrix.Translation((1, 2, 0)) @ Matrix.Rotation(1.1, 4, "Z")
    empties = patch_empties(place_patches(body_in_scene.mesh, patches))
    body_in_scene.armature.matrix_world = place
    truth = np.array(place) @ patch_matrices(bundled_body, patches.triangles, rest(bundled_body))
    distance, angle = difference(read_empties(empties, np.array([1.0])), truth)
    assert distance < 1e-5
    assert angle < 0.01


def test_names_numbers_and_regions_are_readable(body_in_scene, all_patches):
    collection = place_patches(body_in_scene.mesh, all_patches, size=0.02)
    empties = patch_empties(collection)
    assert collection.name == "Patches"
    assert [empty.name for empty in empties] == list(all_patches.names)
    assert [empty["patch"] for empty in empties] == list(range(512))
    assert [empty["region"] for empty in empties] == list(all_patches.regions)
    assert all(empty.parent == body_in_scene.mesh and empty.parent_type == "VERTEX_3" for empty in empties)
    assert all(empty.empty_display_size == pytest.approx(0.02) for empty in empties)
    carriers = [empty.parent_vertices[:] for empty in empties]
    np.testing.assert_array_equal(carriers, all_patches.triangles)


def test_renamed_empties_keep_their_order(body_in_scene, patches):
    collection = place_patches(body_in_scene.mesh, patches)
    for number, empty in enumerate(patch_empties(collection)):
        empty.name = f"{99 - number} mine"
    carriers = [empty.parent_vertices[:] for empty in patch_empties(collection)]
    np.testing.assert_array_equal(carriers, patches.triangles)


def test_they_can_be_removed(body_in_scene, patches):
    collection = place_patches(body_in_scene.mesh, patches)
    remove_patches(collection)
    assert set(bpy.data.objects) == set(body_in_scene)
    assert not bpy.data.collections


@pytest.mark.usefixtures("empty_file")
def test_two_sets_in_one_file_do_not_mix(bundled_body, patches):
    first, second = add_body(bundled_body), add_body(bundled_body)
    one, two = place_patches(first.mesh, patches), place_patches(second.mesh, patches)
    assert {empty.parent for empty in patch_empties(one)} == {first.mesh}
    assert {empty.parent for empty in patch_empties(two)} == {second.mesh}
    remove_patches(one)
    assert len(patch_empties(two)) == len(patches)


@pytest.mark.usefixtures("empty_file")
def test_patches_of_another_body_are_refused(patches):
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(ValueError, match="not of this body"):
        place_patches(bpy.context.active_object, patches)
    assert not bpy.data.collections
