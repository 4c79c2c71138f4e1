# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of a body beside a body, for a second map: it moves as the one does that it was copied from."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from .base.body import matrix, rest_vertices
from .heatmap import paint_colours, remove_heatmaps, show_heatmap

BESIDE = "w2w beside"
"""Custom property of a body's copy: name of the body that it was copied from."""

GAP = 0.15
"""Metres between the two at rest."""

ASIDE = "Beside"
"""Name of the modifier that moves the copy's surface aside."""


def add_beside(mesh: bpy.types.Object, model: bpy.types.Object) -> bpy.types.Object:
    """Put a copy of a model, this body or another, to the right of a body; it cannot be selected.

    The surface is moved aside after the armature has posed it: the copy needs no armature of its own.
    """
    copy = bpy.data.objects.new(f"{mesh.name} Beside", model.data.copy())
    copy[BESIDE] = model.name
    copy.parent, copy.parent_type = model.parent, model.parent_type
    copy.matrix_parent_inverse = model.matrix_parent_inverse
    copy.matrix_basis = model.matrix_basis
    for modifier in model.modifiers:
        if modifier.type == "ARMATURE":
            posed = copy.modifiers.new(modifier.name, "ARMATURE")
            posed.object = modifier.object
            posed.use_deform_preserve_volume = modifier.use_deform_preserve_volume
    aside = copy.modifiers.new(ASIDE, "DISPLACE")
    aside.direction, aside.space, aside.mid_level = "X", "LOCAL", 0.0
    copy.hide_select = True
    homes = mesh.users_collection or (bpy.context.scene.collection,)
    homes[0].objects.link(copy)
    follow(copy, mesh, model)
    return copy


def fits(copy: bpy.types.Object, model: bpy.types.Object) -> bool:
    """Whether a copy is still one of this body."""
    return copy.get(BESIDE) == model.name and len(copy.data.vertices) == len(model.data.vertices)


def follow(copy: bpy.types.Object, mesh: bpy.types.Object, model: bpy.types.Object) -> None:
    """Give a copy the shape that its model has now, and put it beside the body again."""
    model.update_from_editmode()
    points = rest_vertices(model)
    copy.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    copy.data.update()
    from_body = _right_edge(mesh) - matrix(model.matrix_world)[0, 3]
    world = matrix(model.matrix_world)[:3, :3]
    reach = float((points @ world.T)[:, 0].min())
    aside = next(modifier for modifier in copy.modifiers if modifier.name == ASIDE)
    aside.strength = (from_body + GAP - reach) / max(float(np.linalg.norm(world[:, 0])), 1e-9)


def paint_beside(copy: bpy.types.Object, name: str, colours: np.ndarray) -> None:
    """Show one map on a copy, in place of the one before; colours are sRGB, shape (V, 3)."""
    remove_heatmaps(copy)
    paint_colours(copy.data, name, colours)
    show_heatmap(copy, name)


def remove_beside(copies: Sequence[bpy.types.Object]) -> None:
    """Remove copies and their meshes."""
    bpy.data.batch_remove([*copies, *(copy.data for copy in copies)])


def _right_edge(mesh: bpy.types.Object) -> float:
    """How far a body reaches to the right at rest, along x of the world, metres."""
    world = matrix(mesh.matrix_world)
    return float((rest_vertices(mesh) @ world[:3, :3].T)[:, 0].max() + world[0, 3])
