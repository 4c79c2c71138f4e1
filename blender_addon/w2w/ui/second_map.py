# SPDX-License-Identifier: GPL-3.0-or-later
"""A second map side by side with the one shown: of another activity, or of another body of the scene."""

from __future__ import annotations

import bpy

from ..core.colours import patch_colours
from ..scene import heatmap
from ..scene.second_body import add_beside, fits, follow, paint_beside, remove_beside
from .on_body import is_there
from .scores import beside_of, beside_scores, colour_range, shown_scores, view_of
from .state import patches_of, utility_of


def is_ranked(body: bpy.types.Object) -> bool:
    """Whether a body in a scene has a map."""
    return is_there(body) and utility_of(body.w2w) is not None and patches_of(body) is not None


def paint(body: bpy.types.Object) -> None:
    """Show the second map on the copy, which stands anew where it is of another body now."""
    study, other = body.w2w, beside_of(body.w2w)
    if other is None:
        if study.beside is not None:  # taken out of the scene by hand
            study.beside = None
        return
    shown, patches = other.id_data, patches_of(other.id_data)
    if patches is None or shown.data.is_editmode:
        return
    model = (
        body if len(body.data.vertices) == len(patches.labels) else shown
    )  # two maps on one body, if it can be
    if not fits(study.beside, model):
        remove_beside([study.beside])
        study.beside = add_beside(body, model)
    follow(study.beside, body, model)
    utility, scores = utility_of(other), beside_scores(study)
    low, high = colour_range(study, shown_scores(study, utility_of(study)), utility_of(study))
    colours = patch_colours(patches, scores, low, high, study.colour_map, utility.colour_span)
    paint_beside(study.beside, heatmap.MEAN, colours)


def bodies_beside(body: bpy.types.Object) -> list[bpy.types.Object]:
    """Other bodies that show this one's map beside their own."""
    return [
        item
        for item in bpy.data.objects
        if item.type == "MESH"
        and item != body
        and item.w2w.beside_body == body
        and item.w2w.beside is not None
    ]


def name_of(study: bpy.types.PropertyGroup) -> str:
    """What the second map is called; with its body's name where it is of another."""
    other = beside_of(study)
    if other is None:
        return ""
    index = view_of(other, study.beside_view)
    name = "Mean of activities" if index <= 0 else other.activities[index - 1].name
    return name if other == study else f"{name} ({other.id_data.name})"


def owner_of(item: bpy.types.Object) -> bpy.types.Object | None:
    """The body that a copy stands beside, where a spot on one is the same spot on the other."""
    for body in bpy.data.objects:
        if body.type == "MESH" and body.w2w.is_body and body.w2w.beside == item:
            return body if len(body.data.vertices) == len(item.data.vertices) else None
    return None


def remove(body: bpy.types.Object) -> None:
    """Take the second map away."""
    study = body.w2w
    if study.beside is not None:
        remove_beside([study.beside])
    study.beside = None
