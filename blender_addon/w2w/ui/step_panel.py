# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels of the five steps share: what they wait for, and what came out of their buttons."""

from __future__ import annotations

import bpy

from . import jobs
from .choosing import TITLE as CHOOSING
from .result_panels import W2WPanel
from .text import draw_outcome, draw_text

Context = bpy.types.Context
Layout = bpy.types.UILayout


class StepPanel(W2WPanel):
    """A step: its header tells whether it is done, its body what it needs."""

    bl_parent_id = "W2W_PT_main"
    titles: tuple[str, ...] = ()
    """Jobs that the step's buttons start: what comes out of them is shown beside these."""

    def draw_header_preset(self, context: Context) -> None:
        if self.is_done(context):
            self.layout.label(text="", icon="CHECKMARK")

    def draw(self, context: Context) -> None:
        missing = self.missing(context)
        content = self.layout.column()
        content.use_property_split = True
        content.use_property_decorate = False
        content.enabled = jobs.running is None
        if missing:
            draw_text(content, context, missing, icon="INFO")
        else:
            self.draw_step(context, content)
        draw_outcome(self.layout, context, self.titles)

    def missing(self, context: Context) -> str:
        """What this step needs before it makes sense; empty where nothing."""
        return ""

    def is_done(self, context: Context) -> bool:
        """Whether the step is done."""
        return False

    def draw_step(self, context: Context, layout: Layout) -> None:
        """Draw the step itself."""


def beside_their_buttons() -> set[str]:
    """Titles of the jobs whose outcome is shown in a step's panel; that of others stands at the top."""
    return {CHOOSING}.union(*(panel.titles for panel in StepPanel.__subclasses__()))
