# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the lists of clips and activities."""

from __future__ import annotations

from pathlib import Path

import bpy

from .baking import UNBAKED
from .counting import COUNTED
from .scores import activity_scores
from .state import BAKED, FAILED, STALE, bake_settings, playing_clip, state_of, utility_of

WEIGHT_WIDTH, SCORE_WIDTH = 2.6, 2.0
"""Of a weight and a score, in heights of a row."""

ACTIVITY_ROWS = (4, 10)
"""Fewest and most rows of the list of activities."""

ICONS = {BAKED: "CHECKMARK", STALE: "FILE_REFRESH", FAILED: "ERROR"}


class W2W_UL_clips(bpy.types.UIList):
    """Clips, two lines each: tick, name and state; activity, to be edited in place, and frames."""

    def draw_item(
        self, context, layout, data, item, icon, active_data, active_propname, index=0, flt_flag=0
    ) -> None:  # fmt: skip
        state = state_of(item, self.settings(data))
        column = layout.column(align=True)
        row = column.row(align=True)
        row.alert = state == FAILED
        row.prop(item, "selected", text="", emboss=False, icon=_tick(item.selected))
        row.label(text=Path(item.file).stem or item.name, translate=False)
        playing = playing_clip(data.id_data) == item
        mark = "ERROR" if item.bake_path.startswith(UNBAKED) else ICONS.get(state, "BLANK1")
        row.label(text="", icon="PLAY" if playing else mark)
        if state == FAILED:
            return
        row = column.row(align=True)
        row.scale_y = 0.8
        row.label(text="", icon="BLANK1")
        row.prop(item, "activity", text="", emboss=False, placeholder="activity")
        count = row.row()
        count.alignment = "RIGHT"
        count.active = False
        count.label(text=f"{item.n_frames} frames")

    def settings(self, study: bpy.types.PropertyGroup) -> str:
        """What baked clips are compared with."""
        return bake_settings(study)


class W2W_UL_activities(bpy.types.UIList):
    """Activities: what part they take, name, weight, F1 of the best patch."""

    def draw_item(
        self, context, layout, data, item, icon, active_data, active_propname, index=0, flt_flag=0
    ) -> None:  # fmt: skip
        row = layout.row(align=True)
        row.prop(item, "part", text="", emboss=False, icon_only=True)
        name = row.row()
        name.active = item.part == COUNTED
        name.label(text=item.name, translate=False)
        if item.part == COUNTED:
            weight = row.row()
            weight.ui_units_x = WEIGHT_WIDTH
            weight.prop(item, "weight", text="")
        utility = utility_of(data)
        if utility is not None and index < utility.f1.shape[1]:
            best = row.row()
            best.alignment = "RIGHT"
            best.ui_units_x = SCORE_WIDTH
            best.label(text=f"{activity_scores(data, utility)[:, index].max():.2f}")


def draw_activities(layout: bpy.types.UILayout, study: bpy.types.PropertyGroup, right: str) -> None:
    """Draw the list of activities under a line that says what stands in it; `right` of its right side."""
    row = layout.row()
    row.active = False
    row.label(text="Activity")
    heading = row.row()
    heading.alignment = "RIGHT"
    heading.label(text=right)
    rows, most = ACTIVITY_ROWS
    layout.template_list(
        "W2W_UL_activities", "", study, "activities", study, "activity_index", rows=rows, maxrows=most
    )


def _tick(on: bool) -> str:
    return "CHECKBOX_HLT" if on else "CHECKBOX_DEHLT"


CLASSES = (W2W_UL_clips, W2W_UL_activities)
