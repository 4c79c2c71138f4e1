# SPDX-License-Identifier: GPL-3.0-or-later
"""The maps that are shown: the legend of their colours, and a second one on a copy beside the body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import bpy

from ...core.colours import DIFFERENCE_MAP, difference_range, patch_colours
from ...core.ranking.utility import UtilityMap
from ...scene import heatmap
from ...scene.second_body import add_beside, fits, follow, paint_beside, remove_beside
from ..study.scores import (
    EXPECTED,
    beside_of,
    beside_scores,
    colour_range,
    minus_index,
    range_note,
    shown_scores,
    view_index,
    view_of,
)
from ..study.state import patches_of, utility_of

Group = bpy.types.PropertyGroup

BODIES_APART = 2.0
"""Widths of the legend from the middle of one body to that of the next, for it to stand between them."""


class Legend(NamedTuple):
    """Title, numbers and note beside the colours."""

    name: str
    title: str
    low: float
    high: float
    colour_map: str
    note: str
    number: str
    """Format of scores."""
    beside: str = ""
    """Name of the map beside."""


def legend(study: Group, utility: UtilityMap) -> Legend:
    """The legend of the heatmap that is shown."""
    scores, name = shown_scores(study, utility), map_name(study, view_index(study))
    if minus_index(study) >= 0:
        name = f"{name} minus {map_name(study, minus_index(study))}"
        return Legend(name, "Difference of F1", *difference_range(scores), DIFFERENCE_MAP, "", "+.2f")
    low, high = colour_range(study, scores, utility)
    title = "Expected F1" if study.scores == EXPECTED else "F1 on these clips"
    note = range_note(study, scores, utility)
    return Legend(name, title, low, high, study.colour_map, note, ".2f", name_of(study))


def left_of_legend(width: float, left: float, right: float, bodies: Sequence[float]) -> float:
    """Left edge of a legend, pixels: midway between two bodies that leave it room, else at the right.

    `left` and `right` are the edges of what no panel and no card covers, `bodies` the middles of two bodies
    side by side; empty where one stands alone.
    """
    if len(bodies) == 2 and abs(bodies[1] - bodies[0]) >= BODIES_APART * width:
        between = (sum(bodies) - width) / 2
        if left <= between <= right - width:
            return between
    return right - width


def map_name(study: Group, index: int) -> str:
    """Name of a heatmap by its number."""
    return "Mean of activities" if index == 0 else study.activities[index - 1].name


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
    same = len(body.data.vertices) == len(patches.labels)
    model = body if same else shown  # two maps on one body, if it can be
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
    others = [item for item in bpy.data.objects if item.type == "MESH" and item != body]
    return [item for item in others if item.w2w.beside_body == body and item.w2w.beside is not None]


def name_of(study: Group) -> str:
    """Name of the second map; with its body's name where that is another."""
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
