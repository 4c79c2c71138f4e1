# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose Sensors: what `w2w place` finds in a finished ranking, as a job of the panel's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import bpy
from bpy.props import BoolProperty

from ..core.body.body import Body
from ..core.clip_ranking import WindowLabels, choose_worn, rank_together, same_motions
from ..core.findings.advice_content import advice_content
from ..core.patches.patches import PatchSet
from ..core.ranking.inputs import PlaceBlocks
from ..core.ranking.pooling import Pooling
from ..core.ranking.utility import UtilityMap
from ..core.results_folder import AT_MOST
from ..core.selection.advice import advise
from ..core.study import StudyConfig
from . import jobs, results, signal_cache
from .baking import as_labelled, body_as_run, ranked_clips, ranking_source
from .jobs import Steps, in_thread
from .on_body import on_body
from .state import config_of, current_body, patches_of, rank_settings, utility_of
from .step2_motions import can_change

TITLE = "Choose Sensors"

Told = Callable[[float], None]


class Worn(NamedTuple):
    """What sensors to wear together are chosen by."""

    inputs: PlaceBlocks
    labels: WindowLabels
    body: Body


class W2W_OT_choose_sensors(bpy.types.Operator):
    """Choose sensors to wear together under your wishes, by one classifier that reads them all"""

    bl_idname = "w2w.choose_sensors"
    bl_label = TITLE
    bl_options = {"REGISTER"}

    together: BoolProperty(
        name="Together",
        description="Choose sensors to wear together, and test the set by the best-of proxy as one",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a ranking, of all activities."""
        if not can_change(cls, context):
            return False
        missing = missing_for_choice(current_body(context))
        cls.poll_message_set(missing)
        return not missing

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Start the work in the background."""
        return jobs.start(self, context, TITLE, choose_steps(current_body(context), self.together))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do the work at once."""
        return jobs.run_now(self, TITLE, choose_steps(current_body(context), self.together))


def missing_for_choice(body: bpy.types.Object) -> str:
    """What stands in the way of choosing sensors; empty where nothing does."""
    study = body.w2w
    if utility_of(study) is None or patches_of(body) is None:
        return "Rank the patches first (step 5)"
    if study.ranked_as != rank_settings(study):
        return "Clips or settings have changed since the ranking: rank again first (step 5)"
    if not results.ticked(study).all():
        return "Tick all activities first: sensors to wear together are chosen for all of them"
    return ""


@on_body
def choose_steps(mesh: bpy.types.Object, together: bool = True) -> Steps:
    """Choose in a thread, then keep and mark what was chosen."""
    study = mesh.w2w
    missing = missing_for_choice(mesh)
    if missing:
        raise ValueError(missing)
    patches, utility, config = patches_of(mesh), utility_of(study), config_of(study)
    worn = _worn_of(mesh, config) if together else None
    content = yield from in_thread(
        lambda told: _choose(patches, utility, config, worn, told), "choosing", 0.0, 1.0
    )
    results.advise(mesh, content)
    sentence = (content["worn_together"] or content["subset"])["sentence"]
    return sentence[0].upper() + sentence[1:]


def _worn_of(mesh: bpy.types.Object, config: StudyConfig) -> Worn:
    """What is needed to choose sensors to wear together, read from the scene."""
    clips = ranked_clips(mesh.w2w)
    lost = [clip.name for clip in clips if not signal_cache.has(clip.signals)]
    if lost:
        raise ValueError(f"The signals of {len(lost)} clips are gone ({lost[0]}): bake them first (step 4)")
    windows, inputs = ranking_source([clip.signals for clip in clips], config)
    ranked = same_motions([as_labelled(clip) for clip in clips], windows)
    return Worn(inputs, WindowLabels.of(ranked, windows), body_as_run(mesh))


def _choose(
    patches: PatchSet, utility: UtilityMap, config: StudyConfig, source: Worn | None, told: Told
) -> dict[str, Any]:
    """The content of a choice, by the steps of `w2w place`."""
    advice = advise(utility, patches, config.target, config.max_places, config.constraints)
    told(0.1)
    worn, together = None, ()
    if source is not None:
        pooling = Pooling.on(source.body, patches)
        told(0.15)
        worn = choose_worn(source.inputs, source.labels, config, utility, patches, pooling)
        told(0.9)
        order = advice.subset.order[:AT_MOST]
        together = rank_together(order, source.inputs, source.labels, config)
    return advice_content(advice, utility, patches, together, worn)


CLASSES = (W2W_OT_choose_sensors,)
