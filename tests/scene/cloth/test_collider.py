# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth lies on a coarse double of a body while it is simulated, and on the body again afterwards."""

import bpy
import numpy as np
import pytest
from scipy.spatial import KDTree

from w2w.core.body.body import vertex_normals
from w2w.scene.base.actions import write_action
from w2w.scene.base.playback import EvaluatedVertices, playing
from w2w.scene.cloth.garments import COARSE_FACES, COLLIDER, coarse_collider, lie_on


@pytest.fixture
def collider(body_in_scene):
    lie_on(body_in_scene.mesh)
    body_in_scene.mesh.collision.cloth_friction = 33
    return body_in_scene


def others(mesh):
    return [item for item in bpy.data.objects if item.type == "MESH" and item != mesh]


def everywhere(item):
    return EvaluatedVertices(item, np.array([0])).everywhere()


def test_the_double_moves_as_the_body_does(collider, bundled_body, waving):
    mesh = collider.mesh
    with playing(collider.armature, write_action(collider.armature, waving)), coarse_collider(mesh):
        (double,) = others(mesh)
        assert 0.9 * COARSE_FACES < len(double.data.polygons) < 1.1 * COARSE_FACES
        assert mesh.modifiers.get(COLLIDER) is None
        assert [modifier.type for modifier in double.modifiers] == ["ARMATURE", "COLLISION"]
        assert double.collision.cloth_friction == 33
        bpy.context.scene.frame_set(20)
        points, skin = everywhere(double), everywhere(mesh)
        assert np.abs(skin - bundled_body.vertices).max() > 0.3
        near = KDTree(skin).query(points)[1]
        normals = vertex_normals(skin, bundled_body.faces)[near]
        height = np.einsum("va,va->v", points - skin[near], normals)
        assert np.percentile(np.abs(height), 98) < 0.004


def test_the_scene_is_left_as_it_was(collider):
    mesh, meshes = collider.mesh, len(bpy.data.meshes)
    with pytest.raises(KeyError), coarse_collider(mesh):
        raise KeyError
    assert others(mesh) == []
    assert len(bpy.data.meshes) == meshes
    assert [modifier.type for modifier in mesh.modifiers] == ["ARMATURE", "COLLISION"]
    assert mesh.collision.cloth_friction == 33


def test_a_body_that_more_than_bones_moves_serves_itself(collider):
    collider.mesh.modifiers.new("Smooth", "SMOOTH")
    with coarse_collider(collider.mesh):
        assert others(collider.mesh) == []
        assert collider.mesh.modifiers.get(COLLIDER) is not None


def test_a_body_that_is_no_collider_of_ours_stays_none(body_in_scene):
    with coarse_collider(body_in_scene.mesh):
        assert others(body_in_scene.mesh) == []
    assert [modifier.type for modifier in body_in_scene.mesh.modifiers] == ["ARMATURE"]
