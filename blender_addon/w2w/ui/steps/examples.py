# SPDX-License-Identifier: GPL-3.0-or-later
"""Try with Example Motions: a body, motions that come with W2W, and the answer to them, by one button."""

from pathlib import Path

import bpy

from ...core.motion.examples import demo_motions
from ...core.reading.clips import RetargetedMotion
from ..jobs import jobs
from ..jobs.jobs import Step, Steps, on_body, part
from ..study import lists, operators
from .body import body_to_fill
from .motion_import import ImportItem, add_clip
from .run_all import run_all_steps

IMPORTED = 0.1
"""About which share of the time it takes until the motions are in."""

KEPT = "what is there stays, and Run All goes on from there"


@on_body
def import_examples(mesh: bpy.types.Object) -> Steps:
    """List the motions that come with W2W."""
    motions = demo_motions()
    for number, (file, motion) in enumerate(motions.items()):
        name = Path(file).stem
        item = ImportItem(Path(), "", name, motion.activity, motion.subject)
        add_clip(mesh, RetargetedMotion(motion, "", "W2W", 1.0, ""), item)
        yield Step(number / len(motions), name)
    lists.list_labels(mesh.w2w)
    return ""


@on_body
def example_steps(mesh: bpy.types.Object) -> Steps:
    """List the motions, then run all."""
    yield from part(import_examples(mesh), 0.0, IMPORTED)
    return (yield from part(run_all_steps(mesh), IMPORTED, 1.0))


class W2W_OT_try_examples(operators.OnBody, bpy.types.Operator):
    """See what W2W does: a body, motions that come with W2W, and where to wear a sensor for them"""

    bl_label = "Try with Example Motions"
    bl_options = {"REGISTER"}
    adds_body = True

    missing = operators.needs(lambda body: not len(body.w2w.clips), "This body has motions already")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        body = body_to_fill(context)
        return jobs.start(self, context, self.bl_label, example_steps(body), lambda: KEPT)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return jobs.run_now(self, self.bl_label, example_steps(body_to_fill(context)))
