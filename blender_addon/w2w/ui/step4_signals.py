# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 4: bake the signals that sensors on all patches would give."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from . import jobs
from .baking import bake_steps, to_bake
from .operators import can_change
from .state import current_body, missing_for_bake, selected


class W2W_OT_bake_signals(bpy.types.Operator):
    """Simulate accelerometers and gyroscopes on all patches; Esc cancels"""

    bl_idname = "w2w.bake_signals"
    bl_label = "Bake Signals"
    bl_options = {"REGISTER"}

    which: EnumProperty(
        name="Which",
        items=(
            ("ALL", "All", "Bake every clip whose signals are missing or out of date"),
            ("TICKED", "Ticked", "Bake the ticked clips, or the active one, even if they are up to date"),
        ),
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not can_change(cls, context):
            return False
        missing = missing_for_bake(current_body(context))
        cls.poll_message_set(missing)
        return not missing

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        indices = self.indices(context)
        if not indices:
            return self.nothing_to_do()
        return jobs.start(self, context, "Bake Signals", bake_steps(current_body(context), indices))

    def execute(self, context: bpy.types.Context) -> set[str]:
        indices = self.indices(context)
        if not indices:
            return self.nothing_to_do()
        return jobs.run_now(self, "Bake Signals", bake_steps(current_body(context), indices))

    def indices(self, context: bpy.types.Context) -> list[int]:
        """Numbers of the clips to bake."""
        study = current_body(context).w2w
        if self.which == "ALL":
            return to_bake(study)
        wanted = {clip.name for clip in selected(study) if clip.action is not None}
        return [index for index, clip in enumerate(study.clips) if clip.name in wanted and clip.action]

    def nothing_to_do(self) -> set[str]:
        """Say that all is done."""
        jobs.message = jobs.Message("All signals are up to date", False, self.bl_label)
        self.report({"INFO"}, jobs.message.text)
        return {"FINISHED"}
