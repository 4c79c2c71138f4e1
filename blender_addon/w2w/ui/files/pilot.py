# SPDX-License-Identifier: GPL-3.0-or-later
"""A pilot's recordings against the panel's map: what `w2w pilot` does, beside the chosen sensors."""

from pathlib import Path

import bpy
from bpy.props import StringProperty

from ...core.findings.pilot import Pilot, of_folder
from ...core.study.results import StudyResults
from ..jobs.jobs import Steps, on_body
from ..study import lists, operators
from .needs import missing_for_needs
from .save_results import with_saved


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

    missing = staticmethod(lambda _context, body: missing_for_needs(body))

    def steps(self, body: bpy.types.Object) -> Steps:
        return pilot_steps(body, self.path(), self.at)
