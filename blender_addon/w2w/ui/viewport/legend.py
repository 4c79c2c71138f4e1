# SPDX-License-Identifier: GPL-3.0-or-later
"""Beside a body's map: the legend of its colours, a second map on a copy, and the user's own character."""

import bpy

from ...core.colours import Scale
from ...core.ranking.utility import UtilityMap
from ...drawing.colour_bar import Legend
from ...scene import heatmap
from ...scene.body import character
from ...scene.heatmap import add_beside, fits, follow, paint_beside, remove_beside
from ..jobs.jobs import is_there
from ..study import scores, state

MARK_RADIUS = 1.5
"""Radius of a sensor's ball on a character, in lengths of a patch's axes."""


def legend(study: bpy.types.PropertyGroup, utility: UtilityMap) -> Legend:
    """The legend of the heatmap that is shown."""
    name = map_name(study, scores.view_index(study))
    outdated = "out of date" if state.outdated_at_a_glance(study.id_data) else ""
    if scores.minus_index(study) >= 0:
        name = f"{name} minus {map_name(study, scores.minus_index(study))}"
        scale = Scale.of_difference(scores.shown_scores(study, utility))
        return Legend(**vars(scale) | {"note": outdated}, name=name, number="+.2f")
    scale = scores.scale_of(study, utility)
    return Legend(**vars(scale) | {"note": outdated or scale.note}, name=name, beside=name_of(study))


def map_name(study: bpy.types.PropertyGroup, index: int) -> str:
    """Name of a heatmap by its number."""
    return "Mean of activities" if index == 0 else study.activities[index - 1].name


def paint(body: bpy.types.Object) -> None:
    """Show the second map on the copy, which is made again if it is of another body now."""
    study, other = body.w2w, scores.beside_of(body.w2w)
    if other is None:
        if study.beside is not None:  # taken out of the scene by hand
            study.beside = None
        return
    shown, patches = other.id_data, state.patches_of(other.id_data)
    own, values = state.utility_of(study), scores.beside_scores(study)
    if patches is None or own is None or values is None or shown.data.is_editmode:
        return
    same = len(body.data.vertices) == len(patches.labels)
    model = body if same else shown  # two maps on one body, if it can be
    if not fits(study.beside, model):
        remove_beside([study.beside])
        study.beside = add_beside(body, model)
    follow(study.beside, body, model)
    colours = heatmap.map_colours(study.beside, scores.scale_of(study, own), patches, values)
    paint_beside(study.beside, heatmap.MEAN, colours)


def bodies_beside(body: bpy.types.Object) -> list[bpy.types.Object]:
    """Other bodies that show this one's map as their second."""
    others = [item for item in bpy.data.objects if item.type == "MESH" and item != body]
    return [item for item in others if item.w2w.beside_body == body and item.w2w.beside is not None]


def name_of(study: bpy.types.PropertyGroup) -> str:
    """Name of the second map, with its body's name if that is another."""
    other = scores.beside_of(study)
    if other is None:
        return ""
    name = map_name(other, max(scores.view_of(other, study.beside_view), 0))
    return name if other == study else f"{name} ({other.id_data.name})"


def owner_of(item: bpy.types.Object) -> bpy.types.Object | None:
    """The body next to which a copy stands, if a spot on one is the same spot on the other."""
    bodies = [body for body in bpy.data.objects if body.type == "MESH" and body.w2w.is_body]
    owner = next((body for body in bodies if body.w2w.beside == item), None)
    return owner if owner is not None and len(owner.data.vertices) == len(item.data.vertices) else None


def remove(body: bpy.types.Object) -> None:
    """Take the second map away."""
    if body.w2w.beside is not None:
        remove_beside([body.w2w.beside])
    body.w2w.beside = None


def meshes_of(body: bpy.types.Object) -> list[bpy.types.Object]:
    """Meshes of the character that show the map."""
    rows = [row for row in body.w2w.character_meshes if row.use and row.mesh is not None]
    return [row.mesh for row in rows if is_there(row.mesh) and character.POINT in row.mesh.data.attributes]


def paint_character(body: bpy.types.Object) -> None:
    """Carry the body's heatmaps to the character; a mesh that is edited now or no longer fits is left."""
    for mesh in [mesh for mesh in meshes_of(body) if not mesh.data.is_editmode]:
        try:
            character.carry_heatmaps(body, mesh)
        except ValueError as error:
            body.w2w.fit = str(error)


def show_on_character(body: bpy.types.Object) -> None:
    """Show the heatmap on the character that the body shows."""
    active = body.data.color_attributes.active_color
    for mesh in meshes_of(body):
        if active is not None and active.name in mesh.data.color_attributes:
            heatmap.show_heatmap(mesh, active.name)


def mark_character(body: bpy.types.Object, vertices: list[int], names: list[str]) -> None:
    """Put a ball with its name on the character at each of these vertices of the body, and nowhere else."""
    remove_marks(body)
    study, meshes = body.w2w, meshes_of(body)
    if not meshes or not vertices:
        return
    study.marks = bpy.data.collections.new(f"Sensors on {study.character.name}")
    study.marks.color_tag = "COLOR_01"
    next(iter(study.character.users_collection), bpy.context.scene.collection).children.link(study.marks)
    balls = character.place_marks(body, vertices, meshes, MARK_RADIUS * study.patch_size)
    for ball, vertex, name in zip(balls, vertices, names, strict=True):
        ball.name, ball[character.MARK] = name, vertex
        ball.show_in_front = True
        study.marks.objects.link(ball)


def remove_marks(body: bpy.types.Object) -> None:
    """Take the sensors off the character."""
    study = body.w2w
    if study.marks is not None:
        marks = [item for item in study.marks.objects if character.MARK in item]
        bpy.data.batch_remove([*marks, study.marks])


def show_colours() -> None:
    """Show colour attributes in the solid 3D views of all workspaces and in renders of solids."""
    spaces = (area.spaces.active for screen in bpy.data.screens for area in screen.areas)
    for space in spaces:
        if space.type == "VIEW_3D" and space.shading.type == "SOLID":
            space.shading.color_type = "VERTEX"
    for scene in filter(state.bodies, bpy.data.scenes):
        scene.display.shading.color_type = "VERTEX"  # of renders in Workbench
