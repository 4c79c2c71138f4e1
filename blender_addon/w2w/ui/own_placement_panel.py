# SPDX-License-Identifier: GPL-3.0-or-later
"""Your Placements, below step 3: the spots that you named, and how each does beside the patches."""

from __future__ import annotations

from typing import Any

import bpy

from ..core.ranking.utility import UtilityMap
from ..core.selection.headline import mean_caution
from . import jobs
from .own_placements import is_pending, patch_of_own, scores_of_own
from .result_panels import W2WPanel
from .state import current_body, patches_of, utility_of
from .text import draw_text

Context = bpy.types.Context


class W2W_UL_placements(bpy.types.UIList):
    """Placements of one's own: the name, to be edited in place, expected F1 and rank."""

    def draw_item(
        self, context, layout, data, item, icon, active_data, active_propname, index=0, flt_flag=0
    ) -> None:  # fmt: skip
        """Draw a row."""
        row = layout.row(align=True)
        row.prop(item, "title", text="", emboss=False, icon="PINNED")
        value = row.row()
        value.alignment = "RIGHT"
        scores = scores_of_own(data.id_data, item)
        value.active = scores is not None
        value.label(text=in_short(scores, patch_of_own(data.id_data, item)))


class W2W_PT_own_placements(W2WPanel, bpy.types.Panel):
    """Spots that were named, beside the sampled patches."""

    bl_label = "Your Placements"
    bl_idname = "W2W_PT_own_placements"
    bl_parent_id = "W2W_PT_patches"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """There must be patches, or a list already."""
        body = current_body(context)
        return body is not None and (patches_of(body) is not None or len(body.w2w.own) > 0)

    def draw(self, context: Context) -> None:
        """Draw the list, its buttons, and what is known of the active placement."""
        body, layout = current_body(context), self.layout.column()
        study = body.w2w
        layout.enabled = jobs.running is None
        row = layout.row()
        row.template_list("W2W_UL_placements", "", study, "own", study, "own_index", rows=3, maxrows=8)
        column = row.column(align=True)
        column.operator("w2w.add_placement", text="", icon="ADD")
        column.operator("w2w.remove_placement", text="", icon="REMOVE")
        column.operator("w2w.load_placements", text="", icon="FILE_FOLDER")
        if not len(study.own):
            draw_text(
                layout, context, "Click a spot with Pick Patch (Ctrl Alt W), then + names it", icon="INFO"
            )
        elif 0 <= study.own_index < len(study.own):
            scores = scores_of_own(body, study.own[study.own_index])
            if scores is not None:
                draw_text(layout, context, in_words(scores, utility_of(study)))
        if is_pending(study):
            draw_text(layout, context, "Place Again or Run All takes the list over", icon="INFO")


def in_short(scores: dict[str, Any] | None, patch: int) -> str:
    """A placement in a row of the list."""
    if scores is None:
        return "new" if patch < 0 else "not ranked"
    return f"{scores['expected_f1']:.2f}   {scores['rank']} of {scores['of']}"


def in_words(scores: dict[str, Any], utility: UtilityMap) -> str:
    """What is known of a placement: as the console tells it after a run."""
    low, high = scores["expected_f1_interval"]
    interval = mean_caution(utility) or f"{low:.2f} to {high:.2f}"
    loss = "as good as the best" if scores["as_good"] else f"{scores['loss']:.3f} less than the best"
    rank = f"rank {scores['rank']} of {scores['of']} beside the sampled patches"
    score = f"expected F1 {scores['expected_f1']:.3f} ({interval})"
    return f"{scores['region'].capitalize()}: {score}, {rank}, {loss}."


CLASSES = (W2W_UL_placements, W2W_PT_own_placements)
