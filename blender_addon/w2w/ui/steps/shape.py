# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of the bundled body, as sliders that reshape it in place."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, FloatProperty

from ...core.body.body import Body
from ...core.body.shapes import RANGES, shaped
from ...core.wording import capital
from ...scene.body.reshape import reshape_body
from ..jobs import jobs
from ..study.state import is_silent, usable, without_updates

ALWAYS = ("gender", "muscle", "age", "arms", "legs")
OPTIONAL = ("height", "weight")
"""Parameters that follow from the others unless their switch is on."""

NAMES = (*ALWAYS, *OPTIONAL, *(f"set_{name}" for name in OPTIONAL))


def _reshape(shape: W2W_PG_shape, context: bpy.types.Context) -> None:
    """Follow a slider."""
    if not is_silent():
        apply_shape(shape.id_data)
        jobs.redraw(context)


def slider(
    name: str, label: str, description: str, default: float, unit: str = "NONE", update: object = None
) -> FloatProperty:
    """A slider of a shape parameter over its whole range."""
    low, high = RANGES[name]
    return FloatProperty(
        name=label,
        description=description,
        default=default,
        min=low,
        max=high,
        precision=2,
        unit=unit,
        update=update,
    )


def sliders(update: object = None) -> dict[str, object]:
    """Properties of a body's shape, for a property group or an operator."""
    follows = "Else it follows from the other sliders"
    return {
        "gender": slider("gender", "Gender", "-1 is female, 0 neutral, 1 male", 0.0, update=update),
        "set_height": BoolProperty(name="Set Height", description=follows, update=update),
        "height": slider("height", "Height", "Height in metres", 1.70, "LENGTH", update),
        "set_weight": BoolProperty(name="Set Weight", description=follows, update=update),
        "weight": slider("weight", "Weight (kg)", "Weight in kilograms", 70.0, update=update),
        "muscle": slider("muscle", "Muscle", "0 is average, 1 a body builder", 0.0, update=update),
        "age": slider("age", "Age", "Age in years", RANGES["age"][0], update=update),
        "arms": slider("arms", "Arms", "Length of the arms relative to the average", 1.0, update=update),
        "legs": slider("legs", "Legs", "Length of the legs relative to the average", 1.0, update=update),
    }


class W2W_PG_shape(bpy.types.PropertyGroup):
    """The shape of a bundled body."""

    __annotations__ = sliders(_reshape)


def parameters(shape: bpy.types.bpy_struct) -> dict[str, float]:
    """Sliders as `core.shapes.shaped` takes them."""
    used = [*ALWAYS, *(name for name in OPTIONAL if getattr(shape, f"set_{name}"))]
    return {name: getattr(shape, name) for name in used}


def shaped_body(shape: bpy.types.bpy_struct) -> Body:
    """The bundled body in the shape that sliders say; ValueError if there is no such body."""
    return shaped(Body.bundled(), **parameters(shape))


def copy_shape(source: bpy.types.bpy_struct, target: bpy.types.bpy_struct) -> None:
    """Set sliders as others are, without an answer of theirs."""
    with without_updates():
        for name in NAMES:
            setattr(target, name, getattr(source, name))


def apply_shape(mesh: bpy.types.Object) -> None:
    """Give the body the shape that its sliders say; where that cannot be, say why and leave it."""
    study = mesh.w2w
    try:
        reshape_body(mesh, shaped_body(study.shape), [clip.action for clip in usable(study)])
    except ValueError as error:
        jobs.message = jobs.Message(capital(error), True)
    else:
        jobs.dismiss_error()


def draw_sliders(layout: bpy.types.UILayout, shape: bpy.types.bpy_struct) -> None:
    """Draw the sliders of a property group or an operator."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(shape, "gender", slider=True)
    for name in OPTIONAL:
        row = layout.row(heading=shape.bl_rna.properties[name].name)
        row.prop(shape, f"set_{name}", text="")
        value = row.row()
        value.active = getattr(shape, f"set_{name}")
        value.prop(shape, name, text="", slider=True)
    for name in ALWAYS[1:]:
        layout.prop(shape, name, slider=True)
