# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 5: pick a patch to look at, and the range of colours."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, IntProperty

from ...scene.base.patches import empties_by_patch
from ..jobs import jobs
from ..results import results
from ..study.state import current_body, patches_of
from .body import select_only


class W2W_OT_select_patch(bpy.types.Operator):
    """Look at this patch; with Shift, compare it with the one looked at"""

    bl_idname = "w2w.select_patch"
    bl_label = "Look at Patch"
    bl_options = {"UNDO"}

    patch: IntProperty(name="Patch", description="Number of the patch", min=0)
    compare: BoolProperty(
        name="Compare", description="Keep the patch looked at, and compare this one with it"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        cls.poll_message_set("Place patches first (step 3)")
        body = current_body(context)
        return body is not None and context.mode == "OBJECT" and patches_of(body) is not None

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.compare = event.shift
        return self.execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        body = current_body(context)
        if self.patch >= len(patches_of(body)):
            return jobs.show_error(
                self, f"The body has {len(patches_of(body))} patches, no number {self.patch}"
            )
        pick(context, body, self.patch, self.compare)
        return {"FINISHED"}


class W2W_OT_clear_pick(bpy.types.Operator):
    """Look at no patch any more"""

    bl_idname = "w2w.clear_pick"
    bl_label = "Look at No Patch"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        body = current_body(context)
        return body is not None and context.mode == "OBJECT" and body.w2w.picked >= 0

    def execute(self, context: bpy.types.Context) -> set[str]:
        body = current_body(context)
        body.w2w.picked = body.w2w.compared = -1
        select_only(context, body)
        return {"FINISHED"}


class W2W_OT_fit_range(bpy.types.Operator):
    """Let the fixed colour range span the F1 of all activities"""

    bl_idname = "w2w.fit_range"
    bl_label = "Fit Range to All"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        body = current_body(context)
        return body is not None and bool(body.w2w.utility_key)

    def execute(self, context: bpy.types.Context) -> set[str]:
        results.fit_range(current_body(context))
        return {"FINISHED"}


def pick(
    context: bpy.types.Context, body: bpy.types.Object, patch: int, compare: bool = False, vertex: int = -1
) -> None:
    """Look at a patch, and select its empty where it is visible; `vertex` is where it was clicked."""
    study = body.w2w
    study.picked_vertex = vertex
    compare = compare and study.picked >= 0 and study.picked != patch
    if compare:
        study.compared = patch
    else:
        study.picked, study.compared = patch, -1
    empty = empties_by_patch(study.patch_collection).get(patch)
    if not compare:
        for item in context.selected_objects:
            item.select_set(False)
    if empty is not None and empty.visible_get():
        empty.select_set(True)
        context.view_layer.objects.active = empty
    elif not compare:
        context.view_layer.objects.active = body
