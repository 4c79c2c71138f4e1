# SPDX-License-Identifier: GPL-3.0-or-later
"""Under Patches: your placements, spots that you name by a click or a table; and what the body wears."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ...core.findings.in_words import placement_row, placement_sentence
from ...core.garments.cut import KINDS
from ...core.wording import count, free_name
from ...scene.cloth.bake import check_garment
from ...scene.cloth.garments import KIND, NAMES, dress, lie_on, lies_on_nothing
from ..jobs import jobs
from ..jobs.text import draw_text, styled
from ..results import own_placements
from ..results.own_placements import is_pending, patch_of_own, scores_of_own
from ..steps.patches import missing_pick
from ..study import operators, state
from ..study.counting import Group
from ..study.covers import worn_by
from ..viewport.overlay import picks
from .base import Body, Layout, PartPanel, W2WPanel, draw_info, draw_note

GARMENTS = tuple((kind, NAMES[kind], f"Loose {NAMES[kind].lower()} of cotton") for kind in KINDS)


class W2W_OT_add_placement(operators.OnPatches, bpy.types.Operator):
    """Name the spot that you clicked with Pick Spot: a sensor there is simulated and ranked like a spot"""

    bl_label = "Add Placement Here"

    name: StringProperty(name="Name", description="What you call it: 'strap pod', 'ring'")
    vertex: IntProperty(
        name="Vertex",
        description="Vertex of the body that it is at; -1 is the spot that you clicked",
        default=-1,
        min=-1,
        options={"HIDDEN", "SKIP_SAVE"},
    )

    missing = staticmethod(missing_pick)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        body = state.polled_body(context)
        region = state.placed_patches(body).regions[picks(context, body)[-1]]
        self.name = free_name(f"my {region}", {name.lower() for name in own_placements.by_name(body.w2w)})
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        vertex = self.vertex if self.vertex >= 0 else spot(context, body)
        if vertex >= len(body.data.vertices):
            raise ValueError(f"'{body.name}' has no vertex {vertex}")
        own_placements.add(body, self.name, vertex)
        jobs.dismiss_error()


class W2W_OT_load_placements(operators.AsksForFile, operators.OnBody, bpy.types.Operator):
    """Read placements from a table (csv): name, and vertex or x, y, z in metres on the body at rest"""

    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> str:
        placements = count("placement", own_placements.load(body, self.path()))
        return f"Read {placements} from {self.path().name}. 'Run All' or 'Place Again' adds them"


class W2W_OT_remove_placement(operators.OnBody, bpy.types.Operator):
    """Take the active placement off the list"""

    missing = operators.needs(
        lambda body: 0 <= body.w2w.own_index < len(body.w2w.own), "There is no placement of yours"
    )

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        study = body.w2w
        study.own.remove(study.own_index)
        with state.without_updates():
            study.own_index = max(min(study.own_index, len(study.own) - 1), 0)


def spot(context: bpy.types.Context, body: bpy.types.Object) -> int:
    """The clicked vertex if its patch is the picked one, else the middle of the picked patch."""
    patches, patch, clicked = state.placed_patches(body), picks(context, body)[-1], body.w2w.picked_vertex
    if 0 <= clicked < len(patches.labels) and patches.labels[clicked] == patch:
        return clicked
    return int(patches.vertices[patch])


class W2W_UL_placements(bpy.types.UIList):
    """The user's placements: the name, to be edited in place, expected F1 and rank."""

    def draw_item(
        self, context: bpy.types.Context, layout: Layout, data: Group, item: Group, icon: int,
        active_data: Group, active_propname: str,
    ) -> None:  # fmt: skip
        row = layout.row(align=True)
        row.prop(item, "title", text="", emboss=False, icon="PINNED")
        scores = scores_of_own(data.id_data, item)
        value = styled(row.row(), alignment="RIGHT", active=scores is not None)
        value.label(text=placement_row(scores, patch_of_own(data.id_data, item)), translate=False)


class W2W_PT_own_placements(W2WPanel, bpy.types.Panel):
    """Spots that the user named, besides the sampled patches."""

    @staticmethod
    def is_wanted(body: Body) -> bool:
        return body is not None and (state.patches_of(body) is not None or len(body.w2w.own) > 0)

    def draw(self, context: bpy.types.Context) -> None:
        layout = styled(self.layout.column(), enabled=jobs.running is None)
        body = state.polled_body(context)
        study = body.w2w
        row = layout.row()
        row.template_list("W2W_UL_placements", "", study, "own", study, "own_index", rows=3, maxrows=8)
        column = row.column(align=True)
        column.operator("w2w.add_placement", text="", icon="ADD")
        column.operator("w2w.remove_placement", text="", icon="REMOVE")
        column.operator("w2w.load_placements", text="", icon="FILE_FOLDER")
        if not len(study.own):
            draw_info(layout, context, "Click a spot with Pick Spot (Ctrl Alt W), then + names it")
        elif 0 <= study.own_index < len(study.own):
            scores = scores_of_own(body, study.own[study.own_index])
            if scores is not None:
                draw_text(layout, context, placement_sentence(scores, state.ranking_of(body)))
        if is_pending(study):
            draw_info(layout, context, "Press Place Again or Run All to apply this list")


class W2W_OT_add_garment(operators.OnBody, bpy.types.Operator):
    """Put a loose garment on the body, cut for its shape and moved by Blender's cloth"""

    kind: EnumProperty(name="Garment", items=GARMENTS)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        body.w2w.covers.add().item = dress(body, self.kind)
        jobs.dismiss()


class W2W_OT_wear_garment(operators.OnBody, bpy.types.Operator):
    """Wear the active mesh as a garment: one that follows the body by cloth, shrinkwrap or the like"""

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        item = context.object
        if item is None or item.type != "MESH" or item == body or item in worn_by(body.w2w):
            return "Select the mesh of a garment that is not worn yet"
        return ""

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        item = context.object
        check_garment(item, body)
        if any(modifier.type == "CLOTH" for modifier in item.modifiers):
            lie_on(body)
        body.w2w.covers.add().item = item
        jobs.dismiss()


class W2W_OT_take_off(operators.OnBody, bpy.types.Operator):
    """Take a garment off: W2W's own is removed, another stays in the scene"""

    index: IntProperty(min=0, options={"HIDDEN", "SKIP_SAVE"})

    missing = operators.needs(lambda body: len(body.w2w.covers), "Put a garment on first")

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        garments = body.w2w.covers
        if self.index >= len(garments):
            raise ValueError("There is no such garment")
        item = garments[self.index].item
        garments.remove(self.index)
        if item is not None and KIND in item:
            bpy.data.objects.remove(item)
        if not len(garments):
            lies_on_nothing(body)


class W2W_PT_garments(PartPanel, bpy.types.Panel):
    """Garments on the body."""

    def draw(self, context: bpy.types.Context) -> None:
        layout = styled(self.layout.column(), enabled=jobs.running is None)
        study = state.polled_body(context).w2w
        for index, row in enumerate(study.covers):
            line = layout.row(align=True)
            name = row.item.name if row.item is not None else "(removed)"
            line.label(text=name, icon="MATCLOTH", translate=False)
            line.operator("w2w.take_off", text="", icon="X").index = index
        row = layout.row(align=True)
        for kind in KINDS:
            row.operator("w2w.add_garment", text=NAMES[kind], translate=False, icon="ADD").kind = kind
        layout.operator("w2w.wear_garment", icon="MATCLOTH")
        if len(study.covers):
            text = "Spots below are baked on the cloth, which takes minutes a clip."
            draw_note(layout, context, f"{text} Not yet checked against worn garments.")
