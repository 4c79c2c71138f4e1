# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's heatmaps and chosen sensors on the user's own character."""

from __future__ import annotations

import bpy

from ...scene import heatmap
from ...scene.body import character
from ..jobs.jobs import is_there

MARK_RADIUS = 1.5
"""Radius of a sensor's ball on a character, in lengths of a patch's axes."""


def meshes_of(body: bpy.types.Object) -> list[bpy.types.Object]:
    """Meshes of the character that show the map."""
    rows = [row for row in body.w2w.character_meshes if row.use and row.mesh is not None]
    return [row.mesh for row in rows if is_there(row.mesh) and character.POINT in row.mesh.data.attributes]


def paint(body: bpy.types.Object) -> None:
    """Carry the body's heatmaps to the character; a mesh that is edited now or no longer fits is left."""
    for mesh in meshes_of(body):
        if mesh.data.is_editmode:
            continue
        try:
            character.carry_heatmaps(body, mesh)
        except ValueError as error:
            body.w2w.fit = str(error)
            continue


def show(body: bpy.types.Object) -> None:
    """Show the heatmap on the character that the body shows."""
    active = body.data.color_attributes.active_color
    for mesh in meshes_of(body):
        if active is not None and active.name in mesh.data.color_attributes:
            heatmap.show_heatmap(mesh, active.name)


def clear(body: bpy.types.Object) -> None:
    """Take heatmaps and sensors off the character."""
    for mesh in meshes_of(body):
        heatmap.remove_heatmaps(mesh)
    remove_marks(body)


def mark(body: bpy.types.Object, vertices: list[int] | None = None, names: list[str] | None = None) -> None:
    """Put a ball on the character at each of these vertices of the body, or those of the last call."""
    study = body.w2w
    if vertices is None:
        kept = study.marks.objects if study.marks is not None else ()
        kept = sorted(kept, key=lambda item: item.get(ORDER, 0))
        vertices, names = [item[character.MARK] for item in kept], [item.name for item in kept]
    remove_marks(body)
    meshes = meshes_of(body)
    if not meshes or not vertices:
        return
    study.marks = bpy.data.collections.new(f"Sensors on {study.character.name}")
    study.marks.color_tag = "COLOR_01"
    home = next(iter(study.character.users_collection), bpy.context.scene.collection)
    home.children.link(study.marks)
    balls = character.place_marks(body, vertices, meshes, MARK_RADIUS * study.patch_size)
    for number, (ball, vertex, name) in enumerate(zip(balls, vertices, names, strict=True)):
        ball.name = name
        ball[character.MARK], ball[ORDER] = vertex, number
        ball.show_name = ball.show_in_front = True
        study.marks.objects.link(ball)


ORDER = "w2w order"
"""Custom property of a ball: how many sensors were chosen before it."""


def remove_marks(body: bpy.types.Object) -> None:
    """Take the sensors off the character."""
    study = body.w2w
    if study.marks is not None:
        marks = [item for item in study.marks.objects if character.MARK in item]
        bpy.data.batch_remove([*marks, study.marks])
