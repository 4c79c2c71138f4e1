# SPDX-License-Identifier: GPL-3.0-or-later
"""The top of the tab W2W: its pages, how to begin, the one button, what is going on and what was done."""

import bpy

from ...core.wording import join_words
from ..files.open_results import misses_folder
from ..jobs import jobs
from ..jobs.text import draw_message, draw_progress, draw_text, styled
from ..steps.run_all import as_outcome, missing_for_all
from ..study import lists, state
from ..study.pages import ANSWER, CLIPS, shown_page
from ..viewport.framing import hidden_ones
from .base import Layout, W2WPanel, draw_info, draw_warning

WHAT = (
    "Where on the body should a motion sensor sit? W2W tries hundreds of spots on a body that moves as in "
    "your clips, and says which one tells them apart best."
)


class W2W_PT_main(W2WPanel, bpy.types.Panel):
    """The top: the pages, which body, what is going on."""

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene = self.layout, context.scene.w2w
        styled(layout.row(align=True), scale_y=1.2).prop(context.window_manager, "w2w_page", expand=True)
        if len(state.bodies(context.scene)) > 1:
            layout.prop(scene, "body", text="")
        body = state.current_body(context)
        if body is None:
            draw_beginning(layout, context)
        elif shown_page() == CLIPS or (shown_page() == ANSWER and not state.is_ranked(body)):
            draw_run_all(layout, context, body)
        if body is not None and misses_folder(body.w2w):
            where = body.w2w.results_folder or "the results folder beside this file"
            draw_text(layout, context, f"The signals are gone: they were in {where}", icon="ERROR")
            layout.operator("w2w.locate_results", icon="FILE_FOLDER")
        if others := hidden_ones():
            text = f"Show {join_words([item.name for item in others])} Again"
            layout.operator("w2w.show_others", text=text, translate=False, icon="HIDE_ON")
        if jobs.running is not None:
            layout.label(text=jobs.running.title, translate=False)
            draw_progress(layout, jobs.running)
        elif jobs.message is not None:
            draw_message(layout, context, jobs.message, "" if body is None else said_below(body))


def draw_beginning(layout: Layout, context: bpy.types.Context) -> None:
    """Draw what W2W does, and the two ways to begin."""
    draw_text(layout, context, WHAT)
    column = styled(layout.column(), scale_y=1.4)
    column.operator("w2w.try_examples", icon="PLAY")
    column.operator("w2w.import_folder", text="Add Your Clips", translate=False, icon="FILE_FOLDER")


def said_below(body: bpy.types.Object) -> str:
    """What a message need not say, for the answer's own card does."""
    answer = lists.answer_of(body.w2w) if shown_page() == ANSWER and state.is_ranked(body) else {}
    return as_outcome(answer["sentence"]) if answer else ""


def draw_run_all(layout: Layout, context: bpy.types.Context, body: bpy.types.Object) -> None:
    """Draw the one button, what it waits for, or why it should be pressed again."""
    if not state.usable(body.w2w):
        draw_info(layout, context, "Add clips of what people do, two activities or more")
        return
    styled(layout.column(), scale_y=1.4).operator("w2w.run_all", icon="PLAY")
    if missing := missing_for_all(body):
        draw_info(layout, context, missing)
    elif outdated := state.outdated_at_a_glance(body):
        draw_warning(layout, context, f"Out of date. {outdated}.")
