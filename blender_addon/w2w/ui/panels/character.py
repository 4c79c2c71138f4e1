# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's own character: a rigged figure of the scene that shows the map and the sensors."""

from collections.abc import Collection

import bpy

from ...core.body.body import Body
from ...core.body.shapes import shaped
from ...core.motion.source import UnusableMotion
from ...core.patches.correspondence import Character, likeness
from ...core.wording import restated
from ...scene.base.body import armature_of, body_of
from ...scene.body.adopt import moving_armature
from ...scene.body.character import character_meshes, read_character, tie, untie
from ..jobs import jobs
from ..jobs.text import styled
from ..results import results
from ..steps.body import add_study
from ..steps.import_dialog import source_armatures
from ..study import operators, state
from ..viewport import legend
from ..viewport.framing import BESIDE
from .base import W2WPanel, draw_note

SELECT = "Select the armature or a mesh of a rigged character"


def armature_meant(item: bpy.types.Object | None) -> bpy.types.Object | None:
    """The armature of a character, given it or a mesh that it moves; None if it is W2W's own."""
    if item is None or state.body_of_object(item) is not None:
        return None
    if item.type == "MESH":
        item = moving_armature(item) or item.parent
    return item if item is not None and item.type == "ARMATURE" else None


class W2W_OT_use_character(operators.WorkOperator, bpy.types.Operator):
    """Show map and sensors on the active character too: any rig of a human, its meshes in any topology"""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        cls.poll_message_set(SELECT)
        if context.mode != "OBJECT" or jobs.running is not None:
            return False
        return armature_meant(context.object) in source_armatures(context.scene)

    def work(self, context: bpy.types.Context, body: bpy.types.Object | None) -> None:
        armature = armature_meant(context.object)
        if armature is None:
            raise ValueError(SELECT)
        meshes = character_meshes(armature, context.scene)
        if not meshes:
            raise ValueError(f"No mesh of the scene is moved by '{armature.name}'")
        if any(mesh.data.library is not None for mesh in meshes):
            raise ValueError(f"'{armature.name}' is linked from another file: make it local first")
        with restated(f"{armature.name}:", (UnusableMotion, ValueError)):
            figure = read_character(armature, meshes)
            body = body or _own_likeness(context, figure)
            gap = tie(figure, meshes, body_of(body))
        forget(body, meshes)
        study = body.w2w
        study.character = armature
        with state.without_updates():
            for mesh in meshes:
                study.character_meshes.add().mesh = mesh
        number = f"{len(meshes)} {'mesh' if len(meshes) == 1 else 'meshes'}"
        study.fit = f"{number}, {100 * gap:.1f} cm from the body once laid on it"
        if state.is_ranked(body):
            results.paint(body)
            results.mark_chosen(body)
            legend.show_colours()
        jobs.dismiss()


class W2W_OT_forget_character(operators.WorkOperator, bpy.types.Operator):
    """Take map and sensors off the character; the character itself stays"""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        body = state.current_body(context)
        return body is not None and body.w2w.character is not None and context.mode == "OBJECT"

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        forget(body)


def forget(body: bpy.types.Object, tied: Collection[bpy.types.Object] = ()) -> None:
    """Forget a study's character; meshes `tied` to the body stay so."""
    for row in body.w2w.character_meshes:
        if row.mesh is not None and row.mesh not in tied:
            untie(row.mesh)
    legend.remove_marks(body)
    body.w2w.character_meshes.clear()
    body.w2w.character, body.w2w.fit = None, ""


def _own_likeness(context: bpy.types.Context, figure: Character) -> bpy.types.Object:
    """Add our body next to a character, in its proportions."""
    plain = Body.bundled()
    shape = likeness(figure, plain)
    body = add_study(context, shaped(plain, **shape), "Body")
    body.w2w.has_shape = True
    with state.without_updates():
        for name, value in shape.items():
            setattr(body.w2w.shape, name, value)
        body.w2w.shape.set_height = "height" in shape
    low, high = figure.vertices.min(axis=0), figure.vertices.max(axis=0)
    beside = high[0] + BESIDE * shape.get("height", plain.height)
    armature_of(body).location = (beside, (low[1] + high[1]) / 2, low[2])
    return body


class W2W_PT_character(W2WPanel, bpy.types.Panel):
    """The character that shows the map."""

    def draw(self, context: bpy.types.Context) -> None:
        layout = styled(self.layout, enabled=jobs.running is None)
        body = state.current_body(context)
        if body is None or (figure := body.w2w.character) is None or not jobs.is_there(figure):
            layout.operator("w2w.use_character", icon="OUTLINER_OB_ARMATURE")
            return
        row = layout.row(align=True)
        row.label(text=figure.name, icon="OUTLINER_OB_ARMATURE", translate=False)
        row.operator("w2w.forget_character", text="", icon="X")
        column = layout.column(align=True)
        for item in body.w2w.character_meshes:
            if item.mesh is not None:
                column.prop(item, "use", text=item.mesh.name, translate=False)
        draw_note(layout, context, body.w2w.fit)
