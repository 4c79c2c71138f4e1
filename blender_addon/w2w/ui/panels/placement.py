# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors Together: wishes, the best spot that they allow, and the set to wear together."""

from typing import Any

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ...core.findings.in_words import as_sentence, may_move, pilot_sentences, sensor_sentences
from ...core.patches.body_parts import is_understood
from ...core.wording import capital
from ..jobs.text import draw_text, styled
from ..results import results
from ..results.own_placements import spot_name
from ..steps.choosing import missing_for_choice
from ..steps.patches import missing_pick
from ..study import counting, lists, operators, state
from ..study.counting import Group
from ..viewport.overlay import picks
from .base import ResultPanel, draw_info, draw_parameters, form
from .results import can_change_now, draw_headings, draw_spot
from .rows import KINDS


class W2W_OT_add_wish(operators.OnPatches, bpy.types.Operator):
    """Add a wish for where sensors go; type or choose where in its row"""

    kind: EnumProperty(name="Wish", description="What is wished for", items=KINDS, default=state.FORBID)
    place: StringProperty(name="Place", description="Such as 'left wrist', 'head'", options={"SKIP_SAVE"})

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        lists.add_wish(body.w2w, self.kind, self.place)
        results.choose(body)


class W2W_OT_wish_picked(operators.OnPatches, bpy.types.Operator):
    """Add a wish for the region, or your placement, that you look at; for both where you compare two"""

    bl_label = "Add Wish for Picked Spot"

    kind: EnumProperty(name="Wish", description="What is wished for", items=KINDS, default=state.FORBID)

    missing = staticmethod(missing_pick)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        study, patches = body.w2w, state.placed_patches(body)
        there = {(wish.kind, wish.place) for wish in study.wishes}
        for where in dict.fromkeys(spot_name(study, patches, patch) for patch in picks(context, body)):
            if (self.kind, where) not in there or self.kind == state.COST:
                lists.add_wish(study, self.kind, where)
        results.choose(body)


class W2W_OT_remove_wish(operators.OnPatches, bpy.types.Operator):
    """Take this wish away"""

    index: IntProperty(name="Wish", description="Its place in the list", min=0)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        body.w2w.wishes.remove(self.index)
        results.choose(body)


class W2W_PT_placement(ResultPanel, bpy.types.Panel):
    """Wishes, and the sensors to wear together."""

    def draw(self, context: bpy.types.Context) -> None:
        body = state.polled_body(context)
        study, content = body.w2w, styled(form(self.layout), enabled=can_change_now(context))
        draw_parameters(content, study, "choice", "max_places")
        limit = content.row(heading="At Most")
        limit.prop(study, "limit_places", text="")
        number = limit.row()
        if study.limit_places:
            number.prop(study, "max_places", text="sensors", translate=False)
        else:
            number.label(text="no limit", translate=False)
        draw_wishes(content, context, body)
        styled(content.row(), scale_y=1.2).operator("w2w.choose_sensors", icon="VIEWZOOM")
        draw_worn(styled(self.column(context), enabled=can_change_now(context)), context, body)


def draw_wishes(layout: bpy.types.UILayout, context: bpy.types.Context, body: bpy.types.Object) -> None:
    """Draw a row a wish, and the ways to add one."""
    study, patches = body.w2w, state.placed_patches(body)
    column = styled(layout.column(align=True), use_property_split=False)
    for number, wish in enumerate(study.wishes):
        row = column.row(align=True)
        styled(row.row(align=True), ui_units_x=4).prop(wish, "kind", text="")
        is_known = is_understood(patches.regions, patches.names, wish.place)
        where = styled(row.row(align=True), alert=not is_known)
        where.prop(wish, "place", text="", placeholder="where")
        if wish.kind == state.COST:
            styled(row.row(align=True), ui_units_x=3).prop(wish, "cost", text="")
        row.operator("w2w.remove_wish", text="", icon="X").index = number
    row = column.row(align=True)
    row.operator_menu_enum("w2w.add_wish", "kind", text="Add Wish", translate=False, icon="ADD")
    looked_at = [spot_name(study, patches, patch) for patch in picks(context, body) if patch < len(patches)]
    text = " and ".join(dict.fromkeys(looked_at)) or "Picked Spot"
    where = styled(row.row(align=True), active=bool(looked_at))
    where.operator_menu_enum("w2w.wish_picked", "kind", text=text, translate=False, icon="EYEDROPPER")


def draw_worn(layout: bpy.types.UILayout, context: bpy.types.Context, body: bpy.types.Object) -> None:
    """Draw the set to wear together, or what it waits for."""
    study, content = body.w2w, lists.advice_of(body.w2w)
    missing = missing_for_choice(body)
    if content is None:
        if len(study.wishes) and (answer := lists.answer_of(study)):
            draw_text(layout, context, f"One sensor: {answer['sentence']}")
        if missing:
            draw_info(layout, context, missing)
        elif study.advice_text:
            draw_info(layout, context, "The wishes or the ranking have changed: choose again")
        return
    worn = content["worn_together"]
    if worn is None:
        draw_info(layout, context, "Sets to wear together are chosen by the classifier Ridge only")
        return
    draw_sensors(layout, context, study, content)
    layout.operator("w2w.find_needs", text="How Cheap May They Be?", translate=False, icon="TRIA_DOWN_BAR")
    layout.operator("w2w.add_pilot", text="Add a Pilot...", translate=False, icon="COMMUNITY")
    said = pilot_sentences(content["pilot"]) if content.get("pilot") else []
    for found in filter(None, (worn, worn["next_sensor"])):
        said.append(as_sentence(found["sentence"]))
    for sentence in said:
        draw_text(layout, context, sentence)
    if counting.left_out(study):
        draw_info(layout, context, "Chosen from a ranking without the activities that are left out.")


def draw_sensors(
    layout: bpy.types.UILayout, context: bpy.types.Context, study: Group, content: dict[str, Any]
) -> None:
    """Draw a row a sensor of the set: its number, where it goes, how far it may slip and turn; it opens."""
    cards = {card["patch"]: card for card in content.get("cards") or ()}
    column = layout.column(align=True)
    draw_headings(column, "Sensor", "May Slip, Turn")
    for number, (entry, names) in enumerate(
        zip(study.worn, content["worn_together"]["alternatives"], strict=True), start=1
    ):
        card, row = cards.get(entry.patch, {}), styled(column.row(align=True), use_property_split=False)
        icon = "DOWNARROW_HLT" if entry.is_open else "RIGHTARROW"
        row.prop(entry, "is_open", text="", icon=icon, emboss=False)
        split = row.split(factor=0.65, align=True)
        draw_spot(split, study, entry, f"{number}  {capital(card.get('sensor', entry.label))}")
        styled(split.row(), alignment="RIGHT").label(text=may_move(card), translate=False)
        if entry.is_open:
            f1, utility = (entry.f1, entry.low, entry.high), state.ranking_of(study.id_data)
            for sentence in sensor_sentences(entry.label, f1, card, names, utility):
                draw_text(column, context, sentence)
