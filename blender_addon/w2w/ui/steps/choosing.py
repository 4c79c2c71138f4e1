# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose Sensors: what `w2w place` does with a finished ranking, as a job of the panel."""

from __future__ import annotations

from collections.abc import Callable, Generator

import bpy

from ...core.findings.advice_content import advice_content
from ...core.findings.cautions import head
from ...core.selection.advice import Advice
from ...core.study.choosing import Choices, rank_files
from ...core.study.config import StudyConfig
from ...core.study.results import HeldResults
from ...core.wording import capital
from ..jobs.jobs import Step, Steps, in_thread, on_body
from ..results import results
from ..study import counting, lists, operators, signal_cache, state
from .baking import as_labelled, known, known_by, ranked_clips


def missing_for_choice(body: bpy.types.Object) -> str:
    """What prevents choosing sensors, as a sentence, or ""."""
    if not state.is_ranked(body):
        return "Score the spots first, or Run All"
    outdated = state.outdated(body)
    return f"{outdated}: rank again first (page Details)" if outdated else ""


@on_body
def choose_steps(mesh: bpy.types.Object) -> Steps:
    """Choose in a thread, after ranking again if weights have changed; then keep and mark the choice."""
    if missing := missing_for_choice(mesh):
        raise ValueError(missing)
    study, left_out = mesh.w2w, counting.left_out(mesh.w2w)
    reweighed = counting.is_reweighed(study, state.ranking_of(mesh))
    found, advice = yield from advised_steps(mesh, state.config_of(study))
    if not left_out and reweighed:
        results.store(mesh, found.utility, study.ranked_as, found.clips)
        places = signal_cache.places_of(counted_clips(study))
        known[:] = [(known_by(study, places), choices) for _, choices in known]
    cautions = lists.cautions_of(study)
    content = advice_content(advice, found.utility, found.patches, cautions)
    lists.keep_advice(study, content)
    results.mark_chosen(mesh)
    worn = content["worn_together"]
    said = capital(worn["sentence"]) if worn else content["answer"]["sentence"]
    text = head(said, cautions).rstrip(".")
    return f"{text}. Without {', '.join(left_out)}" if left_out else text


class W2W_OT_choose_sensors(operators.JobOperator, bpy.types.Operator):
    """Choose sensors to wear together under your wishes, by one classifier that reads them all"""

    missing = staticmethod(lambda _context, body: missing_for_choice(body))
    steps = staticmethod(choose_steps)


def counted_clips(study: bpy.types.PropertyGroup) -> list[bpy.types.PropertyGroup]:
    """The ranked clips of activities that are not left out."""
    left_out = counting.left_out(study)
    return [clip for clip in ranked_clips(study) if clip.activity not in left_out]


def advised_steps(
    mesh: bpy.types.Object, config: StudyConfig
) -> Generator[Step, None, tuple[HeldResults, Advice]]:
    """The ranked study in the scene as `StudyResults`, and the sensors chosen in it.

    Excluded activities are ignored. The study is ranked again if there are any, or if weights have changed.
    """
    study, utility = mesh.w2w, state.ranking_of(mesh)
    patches, body = state.placed_patches(mesh), state.body_as_run(mesh)
    left_out, reweighed = counting.left_out(study), counting.is_reweighed(study, utility)
    clips = counted_clips(study)
    places, labelled = signal_cache.places_of(clips), [as_labelled(clip) for clip in clips]
    key, map_of = known_by(study, places), None if left_out else utility

    def get_ready(progress: Callable[[float], None]) -> Choices[HeldResults]:
        of, kept = known.pop() if known else (None, None)  # another job does not find it meanwhile
        if kept and of == key:
            return kept.weighed(config)
        return rank_files(labelled, places, patches, body, config, progress, map_of)

    def choose(_: object) -> tuple[HeldResults, Advice]:
        try:
            return choices.study, choices.under(config)
        finally:
            known[:] = [(key, choices)]

    text = "ranking by the new weights" if reweighed else "gathering windows"
    text = f"ranking without {', '.join(left_out)}" if left_out else text
    choices = yield from in_thread(get_ready, text, 0.0, 0.3)
    return (yield from in_thread(choose, "choosing what to wear", 0.3, 1.0))
