# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 1: add the bundled body, or adopt the selected mesh."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..core.body import Body
from ..core.shapes import RANGES, shaped
from ..core.smpl import BodyError, load_body
from ..scene.body import add_body, armature_of, body_of
from .jobs import dismiss, show_error
from .study import body_of_object, current_body


def _slider(name: str, label: str, description: str, default: float, unit: str = "NONE") -> FloatProperty:
    """A slider of a shape parameter over its whole range."""
    low, high = RANGES[name]
    return FloatProperty(
        name=label, description=description, default=default, min=low, max=high, precision=2, unit=unit
    )


class W2W_OT_add_body(bpy.types.Operator):
    """Add the body that comes with W2W; its shape can be set in the panel of the last operation"""

    bl_idname = "w2w.add_body"
    bl_label = "Add Body"
    bl_options = {"REGISTER", "UNDO"}

    gender: _slider("gender", "Gender", "-1 is female, 0 neutral, 1 male", 0.0)
    set_height: BoolProperty(name="Set Height", description="Else it follows from the other sliders")
    height: _slider("height", "Height", "Height in metres", 1.70, unit="LENGTH")
    set_weight: BoolProperty(name="Set Weight", description="Else it follows from the other sliders")
    weight: _slider("weight", "Weight", "Weight in kilograms", 70.0)
    muscle: _slider("muscle", "Muscle", "0 is average, 1 a body builder", 0.0)
    age: _slider("age", "Age", "Age in years", RANGES["age"][0])
    arms: _slider("arms", "Arms", "Length of the arms relative to the average", 1.0)
    legs: _slider("legs", "Legs", "Length of the legs relative to the average", 1.0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Bones can be made only from object mode."""
        cls.poll_message_set("Go back to object mode first")
        return context.mode == "OBJECT"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the shape's sliders in the panel of the last operation."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "gender", slider=True)
        for name in ("height", "weight"):
            row = layout.row(heading=name.title())
            row.prop(self, f"set_{name}", text="")
            value = row.row()
            value.active = getattr(self, f"set_{name}")
            value.prop(self, name, text="", slider=True)
        for name in ("muscle", "age", "arms", "legs"):
            layout.prop(self, name, slider=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add it at the 3D cursor, in a collection of its own."""
        shape = {name: getattr(self, name) for name in ("gender", "muscle", "age", "arms", "legs")}
        shape |= {name: getattr(self, name) for name in ("height", "weight") if getattr(self, f"set_{name}")}
        try:
            body = shaped(Body.bundled(), **shape)
        except ValueError as error:
            return show_error(self, str(error))
        add_study(context, body, "Body")
        return {"FINISHED"}


class W2W_OT_load_body(bpy.types.Operator):
    """Adopt an SMPL body of yours: an official model (npz, pkl), a mesh with SMPL's faces (obj, ply)"""

    bl_idname = "w2w.load_body"
    bl_label = "Load SMPL Body"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.npz;*.pkl;*.obj;*.ply", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Bones can be made only from object mode."""
        cls.poll_message_set("Go back to object mode first")
        return context.mode == "OBJECT"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read it and add it as `W2W_OT_add_body` does."""
        try:
            body = load_body(bpy.path.abspath(self.filepath))
        except BodyError as error:
            return show_error(self, str(error))
        add_study(context, body, body.name)
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


def add_study(context: bpy.types.Context, body: Body, name: str) -> None:
    """Add a body at the 3D cursor, in a collection of its own, and work on it."""
    collection = bpy.data.collections.new(f"W2W {name}")
    context.scene.collection.children.link(collection)
    objects = add_body(body, collection, name)
    objects.armature.location = context.scene.cursor.location
    make_study(context, objects.mesh)
    select_only(context, objects.mesh)
    dismiss()


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


CLASSES = (W2W_OT_add_body, W2W_OT_load_body, W2W_OT_use_mesh, W2W_OT_select_body)
