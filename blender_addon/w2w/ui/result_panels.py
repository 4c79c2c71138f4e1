# SPDX-License-Identifier: GPL-3.0-or-later
"""The results below step 5: the heatmap, the chosen sensors and the table of regions."""

from __future__ import annotations

import bpy

from ..core.selection.headline import short
from . import jobs
from .lists import draw_activities
from .results import findings
from .scores import beside_of, minus_index
from .side_by_side import draw_side_by_side
from .state import current_body, patches_of, utility_of
from .text import draw_text

Context = bpy.types.Context
Layout = bpy.types.UILayout


class W2WPanel:
    """Where all W2W panels are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "W2W"


class ResultPanel(W2WPanel):
    """A part of the results."""

    bl_parent_id = "W2W_PT_utility"

    @classmethod
    def poll(cls, context: Context) -> bool:
        body = current_body(context)
        return body is not None and utility_of(body.w2w) is not None and patches_of(body) is not None


def can_change_now(context: Context) -> bool:
    """Whether colours and choice may be changed: Edit Mode keeps attributes to itself."""
    return jobs.running is None and context.mode != "EDIT_MESH"


class W2W_PT_findings(ResultPanel, bpy.types.Panel):
    """Where to wear one sensor, and how far these clips tell."""

    bl_label = "Where to Wear One"
    bl_idname = "W2W_PT_findings"
    bl_order = 1

    def draw(self, context: Context) -> None:
        body = current_body(context)
        caution, sentences = findings(body.w2w, utility_of(body.w2w), patches_of(body))
        for warning in filter(None, (caution, body.w2w.source_caution)):
            box = self.layout.box()
            box.alert = True
            draw_text(box, context, warning, icon="ERROR", indent=20)
        for sentence in sentences:
            draw_text(self.layout, context, sentence)


class W2W_PT_heatmap(ResultPanel, bpy.types.Panel):
    """What the colours show."""

    bl_label = "Heatmap"
    bl_idname = "W2W_PT_heatmap"
    bl_order = 2

    def draw(self, context: Context) -> None:
        layout, study = self.layout, current_body(context).w2w
        layout.enabled = can_change_now(context)
        layout.use_property_decorate = False
        layout.prop(study, "view", text="")
        draw_activities(layout, study, "Weight, Best F1")
        layout.use_property_split = True
        draw_side_by_side(layout, current_body(context))
        if beside_of(study) is None:
            layout.prop(study, "minus")
        layout.prop(study, "scores")
        if minus_index(study) >= 0:  # a difference has colours of its own
            return
        layout.prop(study, "colour_map")
        layout.prop(study, "fix_range")
        if study.fix_range:
            row = layout.row(align=True)
            row.use_property_split = False
            row.prop(study, "range_low")
            row.prop(study, "range_high")
            row.operator("w2w.fit_range", text="", icon="FULLSCREEN_EXIT")


class W2W_PT_regions(ResultPanel, bpy.types.Panel):
    """The best regions."""

    bl_label = "Top Regions"
    bl_idname = "W2W_PT_regions"
    bl_order = 5

    def draw(self, context: Context) -> None:
        layout, study = self.layout, current_body(context).w2w
        layout.enabled = can_change_now(context)
        draw_rows(layout, study, study.regions, numbered=False)


def draw_rows(
    layout: Layout, study: bpy.types.PropertyGroup, rows: bpy.types.bpy_prop_collection, numbered: bool
) -> None:
    """Draw a table of patches; a click on one looks at it."""
    column = layout.column(align=True)
    for number, entry in enumerate(rows, start=1):
        row = column.row(align=True)
        split = row.split(factor=0.6 if entry.high > 0 else 0.7, align=True)
        text = f"{number}  {entry.label}" if numbered else entry.label
        look = split.operator(
            "w2w.select_patch",
            text=text,
            translate=False,
            depress=entry.patch in (study.picked, study.compared),
        )
        look.patch = entry.patch
        value = split.row(align=True)
        value.alignment = "RIGHT"
        interval = f" ({short(entry.low)}–{short(entry.high)})" if entry.high > 0 else ""
        value.label(text=f"{short(entry.f1)}{interval}" if interval else f"{entry.f1:.3f}")


CLASSES = (W2W_PT_findings, W2W_PT_heatmap, W2W_PT_regions)
