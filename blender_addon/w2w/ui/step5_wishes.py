# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 5: wish for sensors here, forbid them there; by name, or for the region that was clicked."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import own_placements, results
from .overlay import picks
from .placement_properties import KINDS
from .state import COST, FORBID, current_body, patches_of
from .step2_motions import can_change
from .wishes import add_wish


def has_patches(cls: type, context: bpy.types.Context) -> bool:
    """Whether wishes may be changed: there must be patches."""
    if not can_change(cls, context):
        return False
    cls.poll_message_set("Place patches first (step 3)")
    return patches_of(current_body(context)) is not None


class W2W_OT_add_wish(bpy.types.Operator):
    """Add a wish for where sensors go; type or choose where in its row"""

    bl_idname = "w2w.add_wish"
    bl_label = "Add Wish"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Wish", description="What is wished for", items=KINDS, default=FORBID)
    place: StringProperty(
        name="Place", description="Where: 'left wrist', 'head', 'waist'", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be patches."""
        return has_patches(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add it."""
        body = current_body(context)
        add_wish(body.w2w, self.kind, self.place)
        results.choose(body)
        return {"FINISHED"}


class W2W_OT_wish_picked(bpy.types.Operator):
    """Add a wish for the region, or your placement, that you look at; for both where you compare two"""

    bl_idname = "w2w.wish_picked"
    bl_label = "Add Wish for Picked Patch"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Wish", description="What is wished for", items=KINDS, default=FORBID)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A patch must be looked at."""
        if not has_patches(cls, context):
            return False
        cls.poll_message_set("Click a spot on the body first, with the tool Pick Patch (Ctrl Alt W)")
        return bool(picks(context, current_body(context)))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add it, unless it is there already."""
        body = current_body(context)
        study = body.w2w
        there = {(wish.kind, wish.place) for wish in study.wishes}
        for where in dict.fromkeys(own_placements.spot_name(body, patch) for patch in picks(context, body)):
            if (self.kind, where) not in there or self.kind == COST:
                add_wish(study, self.kind, where)
        results.choose(body)
        return {"FINISHED"}


class W2W_OT_remove_wish(bpy.types.Operator):
    """Take this wish away"""

    bl_idname = "w2w.remove_wish"
    bl_label = "Remove Wish"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Wish", description="Its place in the list", min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be wishes."""
        return has_patches(cls, context) and len(current_body(context).w2w.wishes) > 0

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Remove it."""
        body = current_body(context)
        if self.index >= len(body.w2w.wishes):
            return {"CANCELLED"}
        body.w2w.wishes.remove(self.index)
        results.choose(body)
        return {"FINISHED"}


CLASSES = (W2W_OT_add_wish, W2W_OT_wish_picked, W2W_OT_remove_wish)
