# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 3: placements of one's own, by a click on the body or from a table."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

from ..core.wording import capital, free_name
from . import jobs, own_placements
from .overlay import picks
from .state import current_body, patches_of, without_updates
from .step2_motions import can_change
from .step5_wishes import has_patches

Context = bpy.types.Context

LATER = "'Run All' or 'Place Again' puts them among the patches"


class W2W_OT_add_placement(bpy.types.Operator):
    """Name the spot that you clicked with Pick Patch: a sensor there is simulated and ranked like a patch"""

    bl_idname = "w2w.add_placement"
    bl_label = "Add Placement Here"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="What you call it: 'strap pod', 'ring'")
    vertex: IntProperty(
        name="Vertex",
        description="Vertex of the body that it is at; -1 is the spot that you clicked",
        default=-1,
        min=-1,
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        """A spot must have been clicked."""
        if not has_patches(cls, context):
            return False
        cls.poll_message_set("Click a spot on the body first, with the tool Pick Patch (Ctrl Alt W)")
        return bool(picks(context, current_body(context)))

    def invoke(self, context: Context, event: bpy.types.Event) -> set[str]:
        """Ask for its name."""
        body = current_body(context)
        region = patches_of(body).regions[picks(context, body)[-1]]
        self.name = free_name(f"my {region}", {name.lower() for name in own_placements.listed(body.w2w)})
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: Context) -> set[str]:
        """Add it to the list."""
        body = current_body(context)
        vertex = self.vertex if self.vertex >= 0 else spot(context, body)
        if vertex >= len(body.data.vertices):
            return jobs.show_error(self, f"'{body.name}' has no vertex {vertex}")
        try:
            own_placements.add(body, self.name, vertex)
        except ValueError as error:
            return jobs.show_error(self, capital(error))
        jobs.dismiss_error()
        return {"FINISHED"}


class W2W_OT_load_placements(bpy.types.Operator):
    """Read placements from a table (csv): name, and vertex or x, y, z in metres on the body at rest"""

    bl_idname = "w2w.load_placements"
    bl_label = "Load Placements"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="Table", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        """There must be a body."""
        return can_change(cls, context)

    def invoke(self, context: Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> set[str]:
        """Read it."""
        path = Path(bpy.path.abspath(self.filepath))
        try:
            count = own_placements.load(current_body(context), path)
        except (ValueError, OSError) as error:
            return jobs.show_error(self, capital(error))
        text = f"Read {count} placement{'s' * (count != 1)} from {path.name}. {LATER}"
        return jobs.show_done(self, text)


class W2W_OT_remove_placement(bpy.types.Operator):
    """Take the active placement off the list"""

    bl_idname = "w2w.remove_placement"
    bl_label = "Remove Placement"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """There must be one."""
        if not can_change(cls, context):
            return False
        cls.poll_message_set("There is no placement of yours")
        study = current_body(context).w2w
        return 0 <= study.own_index < len(study.own)

    def execute(self, context: Context) -> set[str]:
        """Remove it."""
        study = current_body(context).w2w
        study.own.remove(study.own_index)
        with without_updates():
            study.own_index = max(min(study.own_index, len(study.own) - 1), 0)
        return {"FINISHED"}


def spot(context: Context, body: bpy.types.Object) -> int:
    """The vertex that was clicked, where its patch is looked at; else the middle of the patch that is."""
    patches, patch, clicked = patches_of(body), picks(context, body)[-1], body.w2w.picked_vertex
    if 0 <= clicked < len(patches.labels) and patches.labels[clicked] == patch:
        return clicked
    return int(patches.vertices[patch])


CLASSES = (W2W_OT_add_placement, W2W_OT_load_placements, W2W_OT_remove_placement)
