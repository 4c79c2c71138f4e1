# SPDX-License-Identifier: GPL-3.0-or-later
"""The bundled body, whose sliders reshape it in place, or a mesh of the user's own."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ...core.adopt.smpl import load_body
from ...core.body.body import Body
from ...core.body.regions import regions_of
from ...core.body.shapes import RANGES, shaped
from ...core.motion.source import UnusableMotion
from ...core.reading.reader import Reader
from ...core.wording import capital, restated
from ...scene.base.actions import reshape_body
from ...scene.base.body import add_body, armature_of, body_of, select
from ...scene.body.adopt import adopt_mesh
from ...scene.files.study_file import has_record
from ...scene.heatmap import dress
from ..jobs import jobs
from ..jobs.text import styled
from ..results.restore import restore
from ..study import operators, state
from ..viewport.framing import frame, stand_clear
from ..viewport.legend import show_colours

ALWAYS = ("gender", "muscle", "age", "arms", "legs")
OPTIONAL = ("height", "weight")
"""Parameters that follow from the others unless their switch is on."""

NAMES = (*ALWAYS, *OPTIONAL, *(f"set_{name}" for name in OPTIONAL))


def sliders(update: object = None) -> dict[str, object]:
    """Properties of a body's shape, for a property group or an operator."""
    follows = "Else it follows from the other sliders"

    def slider(name: str, label: str, text: str, default: float, unit: str = "NONE") -> FloatProperty:
        low, high = RANGES[name]
        return FloatProperty(
            name=label, description=text, default=default, min=low, max=high, unit=unit, update=update
        )

    return {
        "gender": slider("gender", "Gender", "-1 is female, 0 neutral, 1 male", 0.0),
        "set_height": BoolProperty(name="Set Height", description=follows, update=update),
        "height": slider("height", "Height", "Height in metres", 1.70, "LENGTH"),
        "set_weight": BoolProperty(name="Set Weight", description=follows, update=update),
        "weight": slider("weight", "Weight (kg)", "Weight in kilograms", 70.0),
        "muscle": slider("muscle", "Muscle", "0 is average, 1 a body builder", 0.0),
        "age": slider("age", "Age", "Age in years", RANGES["age"][0]),
        "arms": slider("arms", "Arms", "Length of the arms relative to the average", 1.0),
        "legs": slider("legs", "Legs", "Length of the legs relative to the average", 1.0),
    }


def _reshape(shape: W2W_PG_shape, context: bpy.types.Context) -> None:
    """Reshape the body after a slider was moved."""
    if not state.is_silent():
        apply_shape(shape.id_data)
        jobs.redraw(context)


class W2W_PG_shape(bpy.types.PropertyGroup):
    """The shape of a bundled body."""

    __annotations__ = sliders(_reshape)


def shaped_body(shape: bpy.types.bpy_struct) -> Body:
    """The bundled body in the shape that the sliders give; ValueError if there is no such body."""
    used = [*ALWAYS, *(name for name in OPTIONAL if getattr(shape, f"set_{name}"))]
    return shaped(Body.bundled(), **{name: getattr(shape, name) for name in used})


def apply_shape(mesh: bpy.types.Object) -> None:
    """Give the body the shape of its sliders, or show why that is impossible and leave it."""
    study = mesh.w2w
    try:
        reshape_body(mesh, shaped_body(study.shape), [clip.action for clip in state.usable(study)])
    except ValueError as error:
        jobs.message = jobs.Message(capital(error), True)
    else:
        jobs.dismiss_error()


def draw_sliders(layout: bpy.types.UILayout, shape: bpy.types.bpy_struct) -> None:
    """Draw the sliders of a property group or an operator."""
    styled(layout, use_property_split=True, use_property_decorate=False)
    layout.prop(shape, "gender", slider=True)
    for name in OPTIONAL:
        row = layout.row(heading=shape.bl_rna.properties[name].name)
        row.prop(shape, f"set_{name}", text="")
        styled(row.row(), active=getattr(shape, f"set_{name}")).prop(shape, name, text="", slider=True)
    for name in ALWAYS[1:]:
        layout.prop(shape, name, slider=True)


class W2W_OT_add_body(operators.WorkOperator, bpy.types.Operator):
    """Add the body that comes with W2W; its shape can be changed at any time"""

    __annotations__ = sliders()

    poll = classmethod(jobs.can_start)

    def draw(self, context: bpy.types.Context) -> None:
        draw_sliders(self.layout, self)

    def work(self, context: bpy.types.Context, _body: bpy.types.Object | None) -> None:
        mesh = add_study(context, shaped_body(self), "Body")
        mesh.w2w.has_shape = True
        with state.without_updates():
            for name in NAMES:
                setattr(mesh.w2w.shape, name, getattr(self, name))
        frame([mesh])


def body_to_fill(context: bpy.types.Context) -> bpy.types.Object:
    """The body that the panel works on; W2W's own is added where there is none."""
    if state.current_body(context) is None:
        bpy.ops.w2w.add_body()
    return state.polled_body(context)


class W2W_OT_reset_shape(operators.OnBody, bpy.types.Operator):
    """Give the body its average shape again"""

    missing = operators.needs(lambda body: body.w2w.has_shape, "Only W2W's own body has a shape to reset")

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        with state.without_updates():
            for name in NAMES:
                body.w2w.shape.property_unset(name)
        apply_shape(body)


class W2W_OT_load_body(operators.AsksForFile, operators.StartsJob, bpy.types.Operator):
    """Adopt an SMPL body of yours: an official model (npz, pkl), a mesh with SMPL's faces (obj, ply)"""

    bl_label = "Load SMPL Body"

    filter_glob: StringProperty(default="*.npz;*.pkl;*.obj;*.ply", options={"HIDDEN"})

    poll = classmethod(jobs.can_start)

    def steps(self, _body: bpy.types.Object | None) -> jobs.Steps:
        return load_steps(self.path())


class W2W_OT_use_mesh(operators.WorkOperator, bpy.types.Operator):
    """Work on the active mesh: one that an armature with SMPL's bones moves, in any spelling"""

    bl_label = "Use Active Mesh"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not jobs.can_start(cls, context):
            return False
        cls.poll_message_set("Select the mesh of another body first")
        found = context.object
        if found is None or found.type not in {"MESH", "ARMATURE", "EMPTY"}:
            return False
        return found.type == "MESH" or state.body_of_object(found) is not None

    def work(self, context: bpy.types.Context, _body: bpy.types.Object | None) -> None:
        mesh = state.body_of_object(context.object) or context.object
        try:
            body_of(mesh)
        except ValueError:
            return self.adopt(context, mesh)
        if has_record(mesh) and not mesh.w2w.is_body:
            restore(mesh)
        make_study(context, mesh)
        jobs.dismiss()

    def adopt(self, context: bpy.types.Context, mesh: bpy.types.Object) -> None:
        """Make a body of a mesh whose rig spells SMPL's bones in another way (m_avg_Pelvis)."""
        hint = "; for map and sensors on any rigged character, press Use Character (Own Character)"
        with restated(lambda error: f"{error}{hint if mesh.find_armature() else ''}", ValueError):
            body = adopt_mesh(mesh)
        add_study(context, body, mesh.name)


class W2W_OT_select_body(operators.OnBody, bpy.types.Operator):
    """Select the body's mesh and nothing else"""

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        select_only(context, body)


def load_steps(path: Path) -> jobs.Steps:
    """Read a body in a thread, which may take long, then add it as `W2W_OT_add_body` does."""
    with Reader() as reader, restated(f"{path}:", UnusableMotion):
        text, work = f"reading {path.name}", partial(load_body, path)
        body = yield from jobs.in_thread(lambda _: reader.read(path, work), text, 0.0, 0.9)
    # kept: where the body is coloured by them they stop no window
    yield from jobs.in_thread(lambda _: regions_of(body), "building the body", 0.9, 1.0)
    add_study(bpy.context, body, body.name)
    return f"Loaded {path.name}"


def add_study(context: bpy.types.Context, body: Body, name: str) -> bpy.types.Object:
    """Add a body at the 3D cursor, clear of what is there, and work on it; returns its mesh."""
    collection = bpy.data.collections.new(f"W2W {name}")
    context.scene.collection.children.link(collection)
    objects = add_body(body, collection, name)
    dress(objects.mesh, body)
    show_colours()
    objects.armature.location = context.scene.cursor.location
    stand_clear(objects.armature, objects.mesh)
    make_study(context, objects.mesh)
    select_only(context, objects.mesh)
    jobs.dismiss()
    return objects.mesh


def make_study(context: bpy.types.Context, mesh: bpy.types.Object) -> None:
    """Let the panel work on a mesh."""
    mesh.w2w.is_body = True
    armature_of(mesh).hide_set(not mesh.w2w.show_armature)
    context.scene.w2w.body = mesh


def select_only(context: bpy.types.Context, item: bpy.types.Object) -> None:
    """Select one object and make it active."""
    select((item,))
    context.view_layer.objects.active = item
