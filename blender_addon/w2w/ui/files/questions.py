# SPDX-License-Identifier: GPL-3.0-or-later
"""Questions about the chosen sensors: how cheap they may be, and how well a pilot's people were recognised.

They are answered on a saved copy of the study, as `w2w need` and `w2w pilot` do.
"""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from ...core.findings.advice_content import need_content, with_needs
from ...core.findings.pilot import Pilot, of_folder
from ...core.study.choosing import find_needs
from ...core.study.results import StudyResults
from ..jobs.jobs import Steps, on_body
from ..study import lists, operators
from .save_results import with_saved

MISSING = operators.needs(lambda body: lists.advice_of(body.w2w), "Choose sensors first (page Answer)")


@on_body
def need_steps(mesh: bpy.types.Object) -> Steps:
    """Find what the study's sensors need, and keep it with their cards."""

    def find(study: StudyResults) -> list[dict[str, Any]]:
        return [need_content(one) for one in find_needs(study)]

    found = yield from with_saved(mesh, find, "trying cheaper sensors")
    content = lists.advice_of(mesh.w2w) or {}
    lists.keep_advice(mesh.w2w, content | {"cards": with_needs(content.get("cards", ()), found)})
    return ". ".join(f"{need['place']}: {need['sentence'] or 'these clips tell nothing'}" for need in found)


class W2W_OT_find_needs(operators.JobOperator, bpy.types.Operator):
    """Find how slow, coarse, noisy and short in range each recommended sensor may be"""

    missing = MISSING
    steps = staticmethod(need_steps)


@on_body
def pilot_steps(mesh: bpy.types.Object, recordings: Path, at: str) -> Steps:
    """Hold a folder of recordings against the study, and keep what it says with the choice."""

    def find(study: StudyResults) -> Pilot:
        return of_folder(study, recordings, at)

    found = yield from with_saved(mesh, find, "reading recordings")
    lists.keep_advice(mesh.w2w, (lists.advice_of(mesh.w2w) or {}) | {"pilot": found.content()})
    return found.sentence()


class W2W_OT_add_pilot(operators.AsksForFolder, operators.StartsJob, bpy.types.Operator):
    """Take the map's level from what people wore: a folder of their phones' exports, as anna/walking.csv"""

    at: StringProperty(name="Worn At", default="left wrist", description="A place or a product")

    missing = MISSING

    def steps(self, body: bpy.types.Object) -> Steps:
        return pilot_steps(body, self.path(), self.at)
