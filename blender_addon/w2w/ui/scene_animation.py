# SPDX-License-Identifier: GPL-3.0-or-later
"""All actions and NLA strips of an armature that is in the scene already, as clips of the body."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..core.motion.import_plan import activity_of_action
from ..scene.scene_takes import LeftOut, SceneTake, scene_takes, stands_beside
from . import jobs
from .label_options import WIDTH, draw_preview
from .motion_import import Wanted, import_steps
from .operators import OnBody
from .state import bodies, current_body

ALL = "*"
"""Stands for every armature."""

BY_ACTION, ONE = "ACTION", "ONE"

LABELLED_BY = (
    (BY_ACTION, "Action Name", "By the name of each action or strip, where that says anything"),
    (ONE, "One for All", "The same activity for all of them"),
)

_items: list[tuple[str, str, str]] = []
"""Blender keeps no reference to the strings of a dynamic enum: this does."""


def source_armatures(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The armatures of a scene that are the user's own."""
    ours = {body.find_armature() for body in bodies(scene)}
    armatures = [item for item in scene.objects if item.type == "ARMATURE" and item not in ours]
    return [item for item in armatures if not stands_beside(item)]


def _armatures(_self: W2W_OT_use_scene_animation, context: bpy.types.Context) -> list[tuple[str, str, str]]:
    found = source_armatures((context or bpy.context).scene)
    _items[:] = [(item.name, item.name, f"The actions of '{item.name}'") for item in found]
    _items.append((ALL, "All Armatures", "The actions of every armature that is not a body's of W2W"))
    return _items


class W2W_OT_use_scene_animation(OnBody, bpy.types.Operator):
    """Take all actions and NLA strips of an armature in the scene as clips; the armature is only read"""

    bl_idname = "w2w.use_scene_animation"
    bl_label = "Use Scene Animation"
    bl_options = {"REGISTER"}

    armature: EnumProperty(
        name="Armature", description="Whose actions and NLA strips become clips", items=_armatures
    )
    labelled_by: EnumProperty(name="Label By", description="What labels the clips", items=LABELLED_BY)
    activity: StringProperty(name="Activity", description="What all of them show")
    again: BoolProperty(
        name="Take Again",
        description="Take actions, too, that are in the list already. One motion twice flatters a ranking: "
        "it is tested on what it was trained on",
        options={"SKIP_SAVE"},
    )

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        found = source_armatures(context.scene)
        return "" if found else "There is no armature in the scene but W2W's own"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        found = [item for item in source_armatures(context.scene) if self.takes(item)[0]]
        if not found:
            return jobs.show_error(self, "No armature of the scene has an action or strip that moves bones")
        self.armature = (context.object if context.object in found else found[0]).name
        return context.window_manager.invoke_props_dialog(self, width=WIDTH)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.prop(self, "armature")
        layout.row().prop(self, "labelled_by", expand=True)
        if self.labelled_by == ONE:
            layout.prop(self, "activity")
        wanted, known, left_out = self.found(context)
        if known or self.again:
            layout.prop(self, "again")
        activities: dict[str, list[str]] = {}
        for item in sorted(wanted, key=lambda item: item.activity):
            activities.setdefault(item.activity, []).append(item.name)
        draw_preview(layout, activities, [*known, *left_out])

    def execute(self, context: bpy.types.Context) -> set[str]:
        wanted, known, left_out = self.found(context)
        if not wanted:
            text = "All of these are in the list already" if known else "There is no action that moves bones"
            return jobs.show_error(self, text)
        steps = import_steps(current_body(context), wanted, left_out)
        return jobs.start(self, context, "Import Motions", steps)

    def found(self, context: bpy.types.Context) -> tuple[list[Wanted], list[LeftOut], list[LeftOut]]:
        """What would be taken, what was taken before, and what is left out."""
        listed = {clip.taken_from for clip in current_body(context).w2w.clips}
        wanted, known, left_out = [], [], []
        for armature in source_armatures(context.scene):
            if self.armature not in (ALL, armature.name):
                continue
            takes, others = self.takes(armature)
            left_out += others if self.armature != ALL else []  # they are another one's, which is there
            for take in takes:
                item = Wanted(Path(), take.name, self.label(take.name, armature.name), take=take)
                if item.taken_from in listed and not self.again:
                    known.append(LeftOut(take.name, "it is in the list already"))
                else:
                    wanted.append(item)
        return wanted, known, left_out

    def takes(self, armature: bpy.types.Object) -> tuple[list[SceneTake], list[LeftOut]]:
        """The takes of an armature; looked for once, for the dialog is drawn often."""
        if not hasattr(self, "_takes"):
            self._takes = {}
        if armature.name not in self._takes:
            self._takes[armature.name] = scene_takes(armature)
        return self._takes[armature.name]

    def label(self, take: str, armature: str) -> str:
        """The activity of a take."""
        if self.labelled_by == ONE:
            return self.activity.strip()
        return activity_of_action(take, armature)


CLASSES = (W2W_OT_use_scene_animation,)
