# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the lists of clips and activities."""

from __future__ import annotations

from pathlib import Path

import bpy

from .baking import UNBAKED
from .scores import activity_scores
from .state import BAKED, FAILED, STALE, bake_settings, playing_clip, state_of, utility_of

ICONS = {BAKED: "CHECKMARK", STALE: "FILE_REFRESH", FAILED: "ERROR"}


class W2W_UL_clips(bpy.types.UIList):
    """Clips, two lines each: tick, name and state; activity, to be edited in place, and frames."""

    def draw_item(
        self, context, layout, data, item, icon, active_data, active_propname, index=0, flt_flag=0
    ) -> None:  # fmt: skip
        """Draw a row."""
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
    """Activities: whether they count, name, F1 of the best patch."""

    def draw_item(
        self, context, layout, data, item, icon, active_data, active_propname, index=0, flt_flag=0
    ) -> None:  # fmt: skip
        """Draw a row."""
        row = layout.row(align=True)
        row.prop(item, "use", text="", emboss=False, icon=_tick(item.use))
        row.label(text=item.name, translate=False)
        utility = utility_of(data)
        if utility is not None and index < utility.f1.shape[1]:
            best = row.row()
            best.alignment = "RIGHT"
            best.label(text=f"{activity_scores(data, utility)[:, index].max():.2f}")


def _tick(on: bool) -> str:
    return "CHECKBOX_HLT" if on else "CHECKBOX_DEHLT"


CLASSES = (W2W_UL_clips, W2W_UL_activities)
