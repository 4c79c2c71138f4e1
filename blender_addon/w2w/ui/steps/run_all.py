# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All: from imported motions to sensors in one go; what was done stays when it is ended early."""

from collections.abc import Callable

import bpy

from ...core.wording import join_words
from ..jobs.jobs import Step, Steps, is_there, on_body, part, start
from ..results.own_placements import is_pending
from ..study import lists, operators, state
from ..study.pages import ANSWER, turn_to
from ..viewport.framing import frame_answer
from .baking import bake_steps, rank_steps, to_bake
from .choosing import choose_steps, missing_for_choice
from .patches import place_steps

TITLE = "Run All"

PLACING, BAKING, RANKING, CHOOSING = 1.0, 0.06, 4.0, 2.0
"""About how many seconds a part takes, `BAKING` for each clip: the bar goes by them."""


def missing_for_all(body: bpy.types.Object) -> str:
    """What prevents running all, as a sentence, or ""."""
    clips = state.usable(body.w2w)
    if missing := state.missing_for_patches(body):
        return missing
    if not clips:
        return "Add clips first, on the page Clips"
    return state.labels_problem(clips) or state.classifier_problem(body.w2w)


@on_body
def run_all_steps(mesh: bpy.types.Object) -> Steps:
    """Do what is missing, part after part; skip what is up to date."""
    study, outcomes = mesh.w2w, []
    place = state.patches_of(mesh) is None or is_pending(study) or state.is_placed_otherwise(study)
    count = len(state.usable(study)) if place else len(to_bake(study))
    rank = count > 0 or not state.is_up_to_date(study)

    def is_choice_missing() -> bool:
        return not missing_for_choice(mesh) and lists.advice_of(study) is None

    parts = (  # about how many seconds each takes, whether it is needed by then, and its steps
        (PLACING if place else 0.0, lambda: place, place_steps),
        (BAKING * count, lambda: to_bake(study), lambda mesh: bake_steps(mesh, to_bake(study), keep=True)),
        (RANKING if rank else 0.0, lambda: not state.is_up_to_date(study), rank_steps),
        (CHOOSING, is_choice_missing, choose_steps),
    )
    whole, done = sum(seconds for seconds, _, _ in parts), 0.0
    for seconds, is_needed, steps in parts:
        if is_needed():
            outcomes.append((yield from part(steps(mesh), done / whole, (done + seconds) / whole)))
        done += seconds
        yield Step(done / whole, "")
    if not outcomes:
        return "Everything is up to date"
    answer = lists.answer_of(study)
    if not answer:
        return ". ".join(outcomes)
    frame_answer(mesh)
    turn_to(ANSWER)
    baked = {clip.name for clip in state.baked(study)}
    failed = join_words([clip.name for clip in state.usable(study) if clip.name not in baked])
    problem = f" Not baked: {failed}; the list of motions says why." if failed else ""
    return f"{as_outcome(answer['sentence'])}{problem}"


def as_outcome(sentence: str) -> str:
    """An answer's sentence as the outcome of Run All."""
    return f"Done: {sentence}"


def kept_of(mesh: bpy.types.Object) -> Callable[[], str]:
    """A function that reports progress if the job is stopped early ("" if nothing was done)."""
    before = _done(mesh)

    def kept() -> str:
        if not is_there(mesh) or _done(mesh) == before:
            return ""
        clips, baked = state.usable(mesh.w2w), state.baked(mesh.w2w)
        return f"{len(baked)} of {len(clips)} clips are baked, and {TITLE} goes on from there"

    return kept


class W2W_OT_run_all(operators.JobOperator, bpy.types.Operator):
    """Do all that is missing, from spots to sensors; Esc stops, and the next time goes on from there"""

    missing = staticmethod(lambda _context, body: missing_for_all(body))
    steps = staticmethod(run_all_steps)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        body = state.current_body(context)
        return start(self, context, TITLE, run_all_steps(body), kept_of(body))


def _done(mesh: bpy.types.Object) -> tuple[object, ...]:
    study = mesh.w2w
    signals = tuple(clip.signals for clip in study.clips)
    return study.patches_key, signals, study.utility_key, study.advice_text
