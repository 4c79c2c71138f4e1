# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts and messages in the sidebar, in as many lines as its width needs."""

from typing import Any

import blf
import bpy

from ...core.wording import wrapped
from . import jobs

FONT = 0
PANEL_POINTS = 11
"""Size of the text in panels at a scale of 1."""


def in_panel(words: str) -> float:
    """Width of one line of a panel's text, pixels."""
    blf.size(FONT, PANEL_POINTS * bpy.context.preferences.system.ui_scale)
    return blf.dimensions(FONT, words)[0]


def styled(layout: bpy.types.UILayout, **look: Any) -> bpy.types.UILayout:
    """A layout with these of its properties set."""
    for name, value in look.items():
        setattr(layout, name, value)
    return layout


TABS_AND_MARGINS, ICON = 56, 22
"""Pixels of the sidebar that no text gets, at a scale of 1."""


def draw_message(
    layout: bpy.types.UILayout, context: bpy.types.Context, message: jobs.Message, known: str = ""
) -> None:
    """Draw the outcome of the last job but for what is `known`, with a button that closes it."""
    text = message.text.removeprefix(known).strip()
    if not text or not message.is_about(context.scene):
        return
    box = styled(layout.box(), alert=message.is_error)
    row, icon = box.row(), "ERROR" if message.is_error else "INFO"
    draw_text(row.column(align=True), context, text, icon, indent=56)
    row.operator("w2w.dismiss_message", text="", icon="X", emboss=False)


def draw_progress(layout: bpy.types.UILayout, job: jobs.Job) -> None:
    """Draw how far a job is, and how to end it."""
    column = layout.column(align=True)
    column.progress(factor=job.fraction, text=job.how_far())
    styled(column.row(), active=False).label(text=f"Esc cancels   {job.text}", translate=False)


def draw_text(
    layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str = "NONE", indent: int = 0
) -> None:
    """Draw a text in as many lines as the sidebar needs; `indent` is what else takes room, in pixels."""
    column = styled(layout.column(align=True), scale_y=0.8)
    taken = TABS_AND_MARGINS + (ICON if icon != "NONE" else 0) + indent
    width = context.region.width - taken * context.preferences.system.ui_scale
    for number, line in enumerate(wrapped(text, width, in_panel)):
        shown = icon if number == 0 else ("BLANK1" if icon != "NONE" else "NONE")
        column.label(text=line, icon=shown, translate=False)
