# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities, below step 5 until there is a ranking: what each shall count in it."""

from __future__ import annotations

import bpy

from . import jobs
from .lists import draw_activities
from .result_panels import W2WPanel
from .state import current_body, utility_of


class W2W_PT_activities(W2WPanel, bpy.types.Panel):
    """What each activity counts; after the ranking the list stands under Heatmap."""

    bl_label = "Activities"
    bl_idname = "W2W_PT_activities"
    bl_parent_id = "W2W_PT_utility"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        body = current_body(context)
        return body is not None and len(body.w2w.activities) > 0 and utility_of(body.w2w) is None

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.enabled = jobs.running is None
        draw_activities(self.layout, current_body(context).w2w, "Weight")


CLASSES = (W2W_PT_activities,)
