# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All: from imported motions to sensors in one go; what was done stays when it is ended early."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import bpy

from ..jobs import jobs
from ..jobs.jobs import Steps, is_there, on_body, part
from ..jobs.text import draw_text
from ..results.own_placements import is_pending
from ..study import advice
from ..study.counting import is_reweighed
from ..study.operators import IsJob
from ..study.state import (
    BAKED,
    bake_settings,
    classifier_problem,
    current_body,
    labels_problem,
    patches_of,
    rank_settings,
    state_of,
    usable,
    utility_of,
)
from ..viewport.framing import frame
from .baking import bake_steps, rank_steps, to_bake
from .choosing import choose_steps, missing_for_choice
from .patches import place_steps

TITLE = "Run All"

PLACING, BAKING, RANKING, CHOOSING = 6.0, 0.4, 12.0, 30.0
"""About how many seconds a part takes, `BAKING` for each clip: the bar goes by them."""


class W2W_OT_run_all(IsJob, bpy.types.Operator):
    """Do all that is missing, from patches to sensors; Esc stops, and the next time goes on from there"""

    bl_idname = "w2w.run_all"
    bl_label = TITLE

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        return missing_for_all(body)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        body = current_body(context)
        return jobs.start(self, context, TITLE, run_all_steps(body), kept_of(body))

    def steps(self, body: bpy.types.Object) -> Steps:
        return run_all_steps(body)


class Part(NamedTuple):
    """A part of the work."""

    seconds: float
    needed: Callable[[], bool]
    steps: Callable[[], Steps]


def missing_for_all(body: bpy.types.Object) -> str:
    """What stands in the way of running all; empty where nothing does."""
    study = body.w2w
    if not usable(study):
        return "Import motions first (step 2)"
    return labels_problem(usable(study)) or classifier_problem(study)


@on_body
def run_all_steps(mesh: bpy.types.Object) -> Steps:
    """Do what is missing, part after part; a part that is up to date is left out."""
    parts, said = _parts(mesh), []
    whole, gone = sum(one.seconds for one in parts), 0.0
    for one in parts:
        if one.needed():
            said.append((yield from part(one.steps(), gone / whole, (gone + one.seconds) / whole)))
        gone += one.seconds
    if not said:
        return "Everything is up to date"
    answer = advice.answer_of(mesh.w2w)
    if not answer:
        return ". ".join(said)
    frame([mesh], int(patches_of(mesh).vertices[answer["patch"]]) if "patch" in answer else None)
    settings = bake_settings(mesh.w2w)
    left = [clip.name for clip in usable(mesh.w2w) if state_of(clip, settings) != BAKED]
    more = f" and {len(left) - 3} more" if len(left) > 3 else ""
    problem = f" Not baked: {', '.join(left[:3])}{more}; the list of motions says why." if left else ""
    return f"Done: {answer['sentence']}{problem}"


def kept_of(mesh: bpy.types.Object) -> Callable[[], str]:
    """What says, when the work is ended early, how far it came; empty where nothing was done."""
    before = _done(mesh)

    def kept() -> str:
        if not is_there(mesh) or _done(mesh) == before:
            return ""
        clips = usable(mesh.w2w)
        baked = sum(state_of(clip, bake_settings(mesh.w2w)) == BAKED for clip in clips)
        return f"{baked} of {len(clips)} clips are baked, and {TITLE} goes on from there"

    return kept


def draw_run_all(layout: bpy.types.UILayout, context: bpy.types.Context, body: bpy.types.Object) -> None:
    """Draw the button, and what it waits for."""
    column = layout.column()
    column.scale_y = 1.4
    column.operator("w2w.run_all", icon="PLAY")
    missing = missing_for_all(body)
    if missing:
        draw_text(layout, context, missing, icon="INFO")


def _parts(mesh: bpy.types.Object) -> list[Part]:
    """The parts of the work in their order, those that will probably be needed with their time."""
    study = mesh.w2w
    place = patches_of(mesh) is None or is_pending(study)
    count = len(usable(study)) if place else len(to_bake(study))
    rank = count > 0 or not _is_ranked(mesh)
    return [
        Part(PLACING * place, lambda: place, lambda: place_steps(mesh)),
        Part(
            BAKING * count, lambda: bool(to_bake(study)), lambda: bake_steps(mesh, to_bake(study), keep=True)
        ),
        Part(RANKING * rank, lambda: not _is_ranked(mesh), lambda: rank_steps(mesh)),
        Part(CHOOSING, lambda: not _is_chosen(mesh), lambda: choose_steps(mesh)),
    ]


def _is_ranked(mesh: bpy.types.Object) -> bool:
    study, utility = mesh.w2w, utility_of(mesh.w2w)
    return (
        utility is not None and study.ranked_as == rank_settings(study) and not is_reweighed(study, utility)
    )


def _is_chosen(mesh: bpy.types.Object) -> bool:
    """Whether sensors are chosen, or cannot be."""
    return bool(missing_for_choice(mesh)) or advice.advice_of(mesh.w2w) is not None


def _done(mesh: bpy.types.Object) -> tuple[object, ...]:
    study = mesh.w2w
    signals = tuple(clip.signals for clip in study.clips)
    return study.patches_key, signals, study.utility_key, study.advice_text
