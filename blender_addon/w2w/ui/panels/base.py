# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes of panels: those of the five steps say what they wait for and what their buttons did."""

import bpy

from ..jobs import jobs
from ..jobs.text import draw_outcome, draw_text
from ..study.operators import is_ranked
from ..study.state import current_body

Context = bpy.types.Context
Layout = bpy.types.UILayout
Body = bpy.types.Object | None


class W2WPanel:
    """A panel in the tab W2W."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "W2W"
    titles: tuple[str, ...] = ()
    """Jobs that the panel's buttons start: their outcome is shown beside these."""


class PartPanel(W2WPanel):
    """A part of a step, which needs a body; closed at first."""

    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return current_body(context) is not None


class ResultPanel(W2WPanel):
    """A part of the results."""

    bl_parent_id = "W2W_PT_utility"

    @classmethod
    def poll(cls, context: Context) -> bool:
        body = current_body(context)
        return body is not None and is_ranked(body)


class StepPanel(W2WPanel):
    """A step: its header tells whether it is done, its body what it needs."""

    bl_parent_id = "W2W_PT_main"

    def draw_header_preset(self, context: Context) -> None:
        body = current_body(context)
        if body is not None and self.is_done(body):
            self.layout.label(text="", icon="CHECKMARK")

    def draw(self, context: Context) -> None:
        body = current_body(context)
        missing = self.missing(body)
        content = form(self.layout)
        content.enabled = jobs.running is None
        if missing:
            draw_info(content, context, missing)
        else:
            self.draw_step(context, content, body)
        draw_outcome(self.layout, context, self.titles)

    def missing(self, body: Body) -> str:
        """Say what this step still needs; empty where nothing."""
        return ""

    def is_done(self, body: bpy.types.Object) -> bool:
        """Whether the step is done on a body."""
        return False

    def draw_step(self, context: Context, layout: Layout, body: Body) -> None:
        """Draw the step itself."""


def form(layout: Layout) -> Layout:
    """A column with names at the left of their values, and nothing to animate them."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_info(layout: Layout, context: Context, text: str) -> None:
    """Draw a text that tells what to do."""
    draw_text(layout, context, text, icon="INFO")


def draw_warning(layout: Layout, context: Context, text: str) -> None:
    """Draw a text in a red box; nothing where there is none."""
    if text:
        box = layout.box()
        box.alert = True
        draw_text(box, context, text, icon="ERROR", indent=20)


def draw_note(layout: Layout, context: Context, text: str) -> None:
    """Draw a text in grey."""
    note = layout.column()
    note.active = False
    draw_text(note, context, text)


def beside_their_buttons() -> set[str]:
    """Titles of the jobs whose outcome is shown in a panel of their own; that of others stands at the top."""
    panels = (*StepPanel.__subclasses__(), *ResultPanel.__subclasses__())
    return {title for panel in panels for title in panel.titles}
