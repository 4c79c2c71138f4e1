# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 1: add the bundled body, or adopt the selected mesh."""

from __future__ import annotations

import bpy

from ..core.body import Body
from ..scene.body import add_body, armature_of, body_of
from .jobs import dismiss, show_error
from .study import body_of_object, current_body


class W2W_OT_add_body(bpy.types.Operator):
    """Add the body that comes with W2W: a T-posed mesh with an armature of 24 bones"""

    bl_idname = "w2w.add_body"
    bl_label = "Add Body"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Bones can be made only from object mode."""
        cls.poll_message_set("Go back to object mode first")
        return context.mode == "OBJECT"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add it at the 3D cursor, in a collection of its own."""
        collection = bpy.data.collections.new("W2W Body")
        context.scene.collection.children.link(collection)
        objects = add_body(Body.bundled(), collection, "Body")
        objects.armature.location = context.scene.cursor.location
        make_study(context, objects.mesh)
        select_only(context, objects.mesh)
        dismiss()
        return {"FINISHED"}


class W2W_OT_use_mesh(bpy.types.Operator):
    """Work on the active mesh: one that an armature with the 24 SMPL-named bones moves"""

    bl_idname = "w2w.use_mesh"
    bl_label = "Use Active Mesh"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be an object that is not the body already."""
        cls.poll_message_set("Select the mesh of another body first")
        found = context.object
        if found is None or found.type not in {"MESH", "ARMATURE", "EMPTY"}:
            return False
        return found.type == "MESH" or body_of_object(found) is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Switch to the body it belongs to, or adopt the mesh as a body."""
        mesh = body_of_object(context.object) or context.object
        try:
            body_of(mesh)
        except ValueError as error:
            return show_error(self, str(error))
        make_study(context, mesh)
        dismiss()
        return {"FINISHED"}


class W2W_OT_select_body(bpy.types.Operator):
    """Select the body's mesh and nothing else"""

    bl_idname = "w2w.select_body"
    bl_label = "Select Body"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a body."""
        return current_body(context) is not None and context.mode == "OBJECT"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Select it."""
        select_only(context, current_body(context))
        return {"FINISHED"}


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


CLASSES = (W2W_OT_add_body, W2W_OT_use_mesh, W2W_OT_select_body)
