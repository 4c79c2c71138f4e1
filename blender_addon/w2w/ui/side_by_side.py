# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that shows a second map side by side with the first, on one scale."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, PointerProperty

from ..scene.second_body import add_beside
from ..scene.source_beside import remove_source
from . import jobs, results, second_map, updates
from .operators import OnRanking
from .scores import MEAN_VIEW, NOTHING, beside_of, view_index, view_items
from .state import bodies, current_body, without_updates

_items: list[tuple[str, str, str, int]] = []
"""Blender keeps no reference to the strings of a dynamic enum: this does."""


def _views(study: SecondMap, _context: bpy.types.Context) -> list[tuple[str, str, str, int]]:
    _items[:] = view_items(beside_of(study) or study)
    return _items


def _is_other(study: SecondMap, item: bpy.types.Object) -> bool:
    return item.type == "MESH" and item.w2w.is_body and item != study.id_data and second_map.is_ranked(item)


class SecondMap:
    """The part of a study's properties that is about a second map beside the one shown."""

    beside: PointerProperty(
        type=bpy.types.Object, name="Second Body", description="The copy that shows the second map"
    )
    beside_view: EnumProperty(
        name="Beside", description="The map beside", items=_views, update=updates.repaint
    )
    beside_body: PointerProperty(
        type=bpy.types.Object,
        name="Of Body",
        description="Body whose map stands beside, such as that of another run; this one where none is given",
        poll=_is_other,
        update=updates.repaint,
    )


class W2W_OT_side_by_side(OnRanking, bpy.types.Operator):
    """Show a second map on a copy of the body beside it, both on one scale; press again to take it away"""

    bl_idname = "w2w.side_by_side"
    bl_label = "Side by Side"

    def execute(self, context: bpy.types.Context) -> set[str]:
        body = current_body(context)
        if beside_of(body.w2w) is None:
            show_beside(body)
        else:
            second_map.remove(body)
        results.paint(body)
        jobs.redraw(context)
        return {"FINISHED"}


def show_beside(body: bpy.types.Object) -> None:
    """Put a copy beside a body; at first it shows another map than the body does."""
    study = body.w2w
    remove_source()  # it would stand where the copy does
    with without_updates():
        study.minus = NOTHING  # a difference has a scale of its own
        study.beside = add_beside(body, body)
        if not study.is_property_set("beside_view"):
            study.beside_view = MEAN_VIEW if view_index(study) else "A1"


def draw_side_by_side(layout: bpy.types.UILayout, body: bpy.types.Object) -> None:
    """Draw the button and, while it is on, what stands beside."""
    study = body.w2w
    is_on = beside_of(study) is not None
    layout.operator("w2w.side_by_side", icon="MOD_MIRROR", depress=is_on)
    if is_on:
        column = layout.column(align=True)
        column.prop(study, "beside_view")
        if len(bodies(bpy.context.scene)) > 1:
            column.prop(study, "beside_body")


CLASSES = (W2W_OT_side_by_side,)
