# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 1: add the bundled body, or adopt the selected mesh."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty

from ...core.adopt.smpl import load_body
from ...core.body.body import Body
from ...scene.base.body import add_body, armature_of, body_of
from ...scene.body.adopt import adopt_mesh
from ...scene.files.study_record import has_record
from ..jobs import jobs
from ..jobs.jobs import Step, Steps, dismiss, in_thread, show_error
from ..results.restore import restore
from ..study.operators import AsksForFile, OnBody
from ..study.state import body_of_object, current_body, without_updates
from ..viewport.framing import frame
from .shape import NAMES, apply_shape, copy_shape, draw_sliders, shaped_body, sliders


class W2W_OT_add_body(bpy.types.Operator):
    """Add the body that comes with W2W; its shape can be changed at any time"""

    bl_idname = "w2w.add_body"
    bl_label = "Add Body"
    bl_options = {"REGISTER", "UNDO"}

    __annotations__ = sliders()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        cls.poll_message_set("Go back to object mode first")
        return context.mode == "OBJECT"

    def draw(self, context: bpy.types.Context) -> None:
        draw_sliders(self.layout, self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            body = shaped_body(self)
        except ValueError as error:
            return show_error(self, str(error))
        mesh = add_study(context, body, "Body")
        mesh.w2w.has_shape = True
        copy_shape(self, mesh.w2w.shape)
        frame([mesh])
        return {"FINISHED"}


class W2W_OT_reset_shape(OnBody, bpy.types.Operator):
    """Give the body its average shape again"""

    bl_idname = "w2w.reset_shape"
    bl_label = "Reset Shape"

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        return "" if body.w2w.has_shape else "Only W2W's own body has a shape to reset"

    def execute(self, context: bpy.types.Context) -> set[str]:
        body = current_body(context)
        with without_updates():
            for name in NAMES:
                body.w2w.shape.property_unset(name)
        apply_shape(body)
        return {"FINISHED"}


class W2W_OT_load_body(AsksForFile, bpy.types.Operator):
    """Adopt an SMPL body of yours: an official model (npz, pkl), a mesh with SMPL's faces (obj, ply)"""

    bl_idname = "w2w.load_body"
    bl_label = "Load SMPL Body"
    bl_options = {"REGISTER"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.npz;*.pkl;*.obj;*.ply", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return jobs.can_start(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return jobs.start(self, context, self.bl_label, load_steps(self.path()))


class W2W_OT_use_mesh(bpy.types.Operator):
    """Work on the active mesh: one that an armature with SMPL's bones moves, in any spelling"""

    bl_idname = "w2w.use_mesh"
    bl_label = "Use Active Mesh"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Go back to object mode first")
            return False
        cls.poll_message_set("Select the mesh of another body first")
        found = context.object
        if found is None or found.type not in {"MESH", "ARMATURE", "EMPTY"}:
            return False
        return found.type == "MESH" or body_of_object(found) is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        mesh = body_of_object(context.object) or context.object
        try:
            body_of(mesh)
        except ValueError:
            return self.adopt(context, mesh)
        try:
            if has_record(mesh) and not mesh.w2w.is_body:
                restore(mesh)
        except ValueError as error:
            return show_error(self, str(error))
        make_study(context, mesh)
        dismiss()
        return {"FINISHED"}

    def adopt(self, context: bpy.types.Context, mesh: bpy.types.Object) -> set[str]:
        """Make a body of a mesh whose rig spells SMPL's bones otherwise (m_avg_Pelvis)."""
        try:
            body = adopt_mesh(mesh)
        except ValueError as error:
            hint = "; for map and sensors on any rigged character, press Use Character (Own Character)"
            return show_error(self, f"{error}{hint if mesh.find_armature() else ''}")
        add_study(context, body, mesh.name)
        return {"FINISHED"}


class W2W_OT_select_body(bpy.types.Operator):
    """Select the body's mesh and nothing else"""

    bl_idname = "w2w.select_body"
    bl_label = "Select Body"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return current_body(context) is not None and context.mode == "OBJECT"

    def execute(self, context: bpy.types.Context) -> set[str]:
        select_only(context, current_body(context))
        return {"FINISHED"}


def load_steps(path: Path) -> Steps:
    """Read a body in a thread, which may take long, then add it as `W2W_OT_add_body` does."""
    body = yield from in_thread(lambda _told: load_body(path), f"reading {path.name}", 0.0, 0.9)
    yield Step(0.9, "building the body")
    add_study(bpy.context, body, body.name)
    return f"Loaded {path.name}"


def add_study(context: bpy.types.Context, body: Body, name: str) -> bpy.types.Object:
    """Add a body at the 3D cursor, in a collection of its own, and work on it; returns its mesh."""
    collection = bpy.data.collections.new(f"W2W {name}")
    context.scene.collection.children.link(collection)
    objects = add_body(body, collection, name)
    objects.armature.location = context.scene.cursor.location
    make_study(context, objects.mesh)
    select_only(context, objects.mesh)
    dismiss()
    return objects.mesh


def make_study(context: bpy.types.Context, mesh: bpy.types.Object) -> None:
    """Let the panel work on a mesh."""
    mesh.w2w.is_body = True
    armature_of(mesh).hide_set(not mesh.w2w.show_armature)
    context.scene.w2w.body = mesh


def select_only(context: bpy.types.Context, item: bpy.types.Object) -> None:
    """Select one object and make it active."""
    for other in context.selected_objects:
        other.select_set(False)
    item.select_set(True)
    context.view_layer.objects.active = item
