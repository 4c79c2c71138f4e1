# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of a body stands beside it, whatever pose that is in, and shows colours of its own."""

import bpy
import numpy as np
import pytest

from w2w.scene.base.body import add_body, matrix, rest_vertices
from w2w.scene.heatmap import (
    BESIDE,
    GAP,
    add_beside,
    fits,
    follow,
    heatmap_names,
    paint_beside,
    paint_colours,
    remove_beside,
)

pytestmark = pytest.mark.usefixtures("empty_file")


def surface(item):
    """Vertices of an object as they are shown, in the world."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    world = matrix(evaluated.matrix_world)
    return rest_vertices(evaluated) @ world[:3, :3].T + world[:3, 3]


def test_it_is_moved_aside_and_follows_every_pose(bundled_body):
    objects = add_body(bundled_body)
    objects.armature.location = (2.0, -1.0, 0.0)
    bpy.context.view_layer.update()
    copy = add_beside(objects.mesh, objects.mesh)
    follow(copy, objects.mesh, objects.mesh)
    bpy.context.view_layer.update()
    aside = surface(copy) - surface(objects.mesh)
    assert np.ptp(aside, axis=0).max() < 1e-4
    assert surface(copy)[:, 0].min() == pytest.approx(surface(objects.mesh)[:, 0].max() + GAP, abs=1e-4)
    objects.armature.pose.bones["left_shoulder"].rotation_mode = "XYZ"
    objects.armature.pose.bones["left_shoulder"].rotation_euler = (0.4, 0.9, -0.3)
    bpy.context.view_layer.update()
    moved = surface(copy) - surface(objects.mesh)
    np.testing.assert_allclose(moved, aside, atol=1e-4)


def test_its_colours_are_its_own(bundled_body):
    mesh = add_body(bundled_body).mesh
    black, white = (np.full((len(bundled_body.vertices), 3), value) for value in (0.0, 1.0))
    paint_colours(mesh.data, "Expected F1", black)
    copy = add_beside(mesh, mesh)
    paint_beside(copy, "Expected F1", white)
    for item, value in ((mesh, 0.0), (copy, 1.0)):
        assert heatmap_names(item) == ["Expected F1"]
        assert item.data.color_attributes.active_color.data[7].color_srgb[0] == value
    assert copy.hide_select


@pytest.mark.slow
def test_it_takes_the_shape_that_its_model_has_now_and_goes_whole(bundled_body):
    mesh = add_body(bundled_body).mesh
    copy = add_beside(mesh, mesh)
    taller = (bundled_body.vertices * [1, 1, 1.1]).astype(np.float32)
    mesh.data.vertices.foreach_set("co", taller.ravel())
    follow(copy, mesh, mesh)
    np.testing.assert_array_equal(rest_vertices(copy), rest_vertices(mesh))
    assert fits(copy, mesh)
    other = add_body(bundled_body, name="Other").mesh
    assert not fits(copy, other)
    remove_beside([copy])
    assert not [item for item in bpy.data.objects if BESIDE in item]
    assert len(bpy.data.meshes) == 2
