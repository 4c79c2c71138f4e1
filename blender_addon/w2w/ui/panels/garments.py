# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments, below step 3: what the body wears; patches that it covers are then on the cloth."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty

from ...core.garments.cut import KINDS
from ...scene.garments.bake import check_garment
from ...scene.garments.cloth import KIND, NAMES, dress, lie_on, lies_on_nothing
from ..jobs import jobs
from ..jobs.text import draw_text
from ..study.garments import worn_by
from ..study.operators import OnBody
from ..study.state import current_body
from .base import W2WPanel

Context = bpy.types.Context

ITEMS = tuple((kind, NAMES[kind], f"Loose {NAMES[kind].lower()} of cotton") for kind in KINDS)


class W2W_OT_add_garment(OnBody, bpy.types.Operator):
    """Put a loose garment on the body, cut for its shape and moved by Blender's cloth"""

    bl_idname = "w2w.add_garment"
    bl_label = "Add Garment"

    kind: EnumProperty(name="Garment", items=ITEMS)

    def execute(self, context: Context) -> set[str]:
        body = current_body(context)
        try:
            item = dress(body, self.kind)
        except ValueError as error:
            return jobs.show_error(self, str(error))
        body.w2w.garments.add().item = item
        jobs.dismiss()
        return {"FINISHED"}


class W2W_OT_wear_garment(OnBody, bpy.types.Operator):
    """Wear the active mesh as a garment: one that follows the body by cloth, shrinkwrap or the like"""

    bl_idname = "w2w.wear_garment"
    bl_label = "Wear Garment"

    @staticmethod
    def missing(context: Context, body: bpy.types.Object) -> str:
        item = context.object
        if item is None or item.type != "MESH" or item == body or item in worn_by(body.w2w):
            return "Select the mesh of a garment that is not worn yet"
        return ""

    def execute(self, context: Context) -> set[str]:
        body, item = current_body(context), context.object
        try:
            check_garment(item, body)
        except ValueError as error:
            return jobs.show_error(self, str(error))
        if any(modifier.type == "CLOTH" for modifier in item.modifiers):
            lie_on(body)
        body.w2w.garments.add().item = item
        jobs.dismiss()
        return {"FINISHED"}


class W2W_OT_take_off(OnBody, bpy.types.Operator):
    """Take a garment off: W2W's own is removed, another stays in the scene"""

    bl_idname = "w2w.take_off"
    bl_label = "Take Off"

    index: IntProperty(options={"HIDDEN", "SKIP_SAVE"})

    @staticmethod
    def missing(context: Context, body: bpy.types.Object) -> str:
        return "" if len(body.w2w.garments) else "Put a garment on first"

    def execute(self, context: Context) -> set[str]:
        body = current_body(context)
        garments = body.w2w.garments
        if not 0 <= self.index < len(garments):
            return {"CANCELLED"}
        item = garments[self.index].item
        garments.remove(self.index)
        if item is not None and KIND in item:
            bpy.data.objects.remove(item)
        if not len(garments):
            lies_on_nothing(body)
        return {"FINISHED"}


class W2W_PT_garments(W2WPanel, bpy.types.Panel):
    """What the body wears."""

    bl_label = "Garments"
    bl_idname = "W2W_PT_garments"
    bl_parent_id = "W2W_PT_patches"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return current_body(context) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout.column()
        layout.enabled = jobs.running is None
        study = current_body(context).w2w
        for index, row in enumerate(study.garments):
            line = layout.row(align=True)
            name = row.item.name if row.item is not None else "(removed)"
            line.label(text=name, icon="MATCLOTH", translate=False)
            line.operator("w2w.take_off", text="", icon="X").index = index
        row = layout.row(align=True)
        for kind in KINDS:
            row.operator("w2w.add_garment", text=NAMES[kind], icon="ADD").kind = kind
        layout.operator("w2w.wear_garment", icon="MATCLOTH")
        if len(study.garments):
            about = layout.column()
            about.active = False
            draw_text(
                about,
                context,
                "Patches below are baked on the cloth, which takes minutes a clip. Not yet checked against "
                "worn garments.",
            )
