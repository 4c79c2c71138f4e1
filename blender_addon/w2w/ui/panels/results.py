# SPDX-License-Identifier: GPL-3.0-or-later
"""The answer, the heatmap, a second one next to it, activities and regions."""

from collections.abc import Sequence
from typing import Any

import bpy

from ...core.findings.cautions import KNOW, OPEN, STOPS, WEAKENS, Caution, below
from ...core.findings.in_words import product_row, sure_sentences
from ...core.selection.headline import short
from ...scene.heatmap import add_beside
from ...scene.motion.source_beside import remove_source
from ..jobs import jobs
from ..jobs.text import draw_text, styled
from ..results import results
from ..study import counting, lists, operators, scores, state
from ..study.counting import Group
from ..study.pages import CLIPS
from ..viewport import legend
from ..viewport.framing import frame, hide_others
from .base import Body, Layout, PartPanel, ResultPanel, draw_outdated, draw_warning

WEIGHT_WIDTH, SCORE_WIDTH = 2.6, 2.0
"""Column widths of weight and score, in row heights."""

GREEN, YELLOW, RED = "COLORSET_03_VEC", "COLORSET_09_VEC", "COLORSET_01_VEC"
"""Icons of a good answer, a weak one and none."""

LIGHTS = {KNOW: (GREEN, "Good answer"), WEAKENS: (YELLOW, "Weak answer"), STOPS: (RED, "No answer yet")}
"""Icon and words over an answer, by the weight of the heaviest caution on it."""

PRODUCTS = 3
"""Products shown."""


def can_change_now(context: bpy.types.Context) -> bool:
    """Whether colours and choice may be changed: Edit Mode keeps attributes to itself."""
    return jobs.running is None and context.mode != "EDIT_MESH"


class W2W_PT_findings(ResultPanel, bpy.types.Panel):
    """The best place for one sensor, and how reliable that is."""

    def draw(self, context: bpy.types.Context) -> None:
        body = state.polled_body(context)
        cautions = lists.cautions_of(body.w2w)
        draw_light(self.layout, context, body, cautions)
        draw_outdated(self.layout, context, body)
        answer, layout = lists.answer_of(body.w2w), self.column(context)
        draw_text(layout, context, answer.get("sentence", ""))
        draw_products(layout, answer.get("products", ())[:PRODUCTS])
        layout.prop(body.w2w, "compare", text="", placeholder="Compare: ring, necklace", icon="VIEWZOOM")
        found, unknown = lists.comparison_of(body.w2w)
        draw_products(layout, found)
        draw_warning(layout, context, unknown)
        for caution in below(cautions)[:OPEN]:
            if caution.weight == STOPS:
                draw_warning(self.layout, context, caution.sentence())
            else:
                draw_text(layout, context, caution.sentence())
        row = self.layout.row(align=True)
        row.operator("w2w.export_presentation", text="Picture", translate=False, icon="RENDER_STILL")
        row.operator("w2w.export_film", text="Film", translate=False, icon="RENDER_ANIMATION")
        row.menu("W2W_MT_export", text="Export", icon="EXPORT")


def draw_light(
    layout: Layout, context: bpy.types.Context, body: bpy.types.Object, cautions: Sequence[Caution]
) -> None:
    """Draw whether the answer is good, weak or none yet, and where that can be mended."""
    icon, words = LIGHTS[cautions[0].weight if cautions else KNOW]
    if state.outdated_at_a_glance(body):
        icon, words = RED, "Out of date"
    row = layout.row(align=True)
    row.label(text=words, icon=icon, translate=False)
    if icon != GREEN:
        row.prop_enum(context.window_manager, "w2w_page", CLIPS, text="To the Clips", icon="FORWARD")


def draw_products(layout: Layout, products: Sequence[dict[str, Any]]) -> None:
    """Draw a row a product: its name, its F1 as a bar, and what it costs against the best spot."""
    column = layout.column(align=True)
    for product in products:
        row = column.split(factor=0.5, align=True)
        name, f1 = product_row(product)
        row.label(text=name, translate=False)
        row.progress(factor=product["expected_f1"], text=f1)


class W2W_PT_sure(ResultPanel, bpy.types.Panel):
    """How sure the answer is."""

    def draw(self, context: bpy.types.Context) -> None:
        body = state.polled_body(context)
        layout = self.column(context)
        known = [each.sentence() for each in below(lists.cautions_of(body.w2w))[OPEN:]]
        if counting.is_as_ranked(body.w2w, utility := state.ranking_of(body)):
            found = sure_sentences(lists.answer_of(body.w2w), utility)
        else:
            found = ["Intervals are of all activities alone."]
        for sentence in (*found, *known):
            draw_text(layout, context, sentence)


class W2W_UL_activities(bpy.types.UIList):
    """Activities: what part they take, name, weight, F1 of the best patch."""

    def draw_item(
        self, context: bpy.types.Context, layout: Layout, data: Group, item: Group, icon: int,
        active_data: Group, active_propname: str, index: int,
    ) -> None:  # fmt: skip
        row = layout.row(align=True)
        row.prop(item, "part", text="", emboss=False, icon_only=True)
        styled(row.row(), active=item.part == counting.COUNTED).label(text=item.name, translate=False)
        if item.part == counting.COUNTED:
            styled(row.row(), ui_units_x=WEIGHT_WIDTH).prop(item, "weight", text="")
        utility = state.utility_of(data)
        if utility is not None and index < utility.f1.shape[1]:
            best = styled(row.row(), alignment="RIGHT", ui_units_x=SCORE_WIDTH)
            best.label(text=f"{scores.activity_scores(data, utility)[:, index].max():.2f}", translate=False)


def draw_headings(layout: Layout, left: str, right: str) -> None:
    """Draw the headings of a table of two columns."""
    row = styled(layout.row(), active=False)
    row.label(text=left, translate=False)
    styled(row.row(), alignment="RIGHT").label(text=right, translate=False)


def draw_activities(layout: Layout, study: bpy.types.PropertyGroup, right: str) -> None:
    """Draw the list of activities under a line with its headings; `right` is the right one."""
    draw_headings(layout, "Activity", right)
    layout.template_list(
        "W2W_UL_activities", "", study, "activities", study, "activity_index", rows=4, maxrows=10
    )


class W2W_PT_activities(PartPanel, bpy.types.Panel):
    """Weights of activities; after the ranking the list stands under Heatmap."""

    @staticmethod
    def is_wanted(body: Body) -> bool:
        return body is not None and len(body.w2w.activities) > 0 and state.utility_of(body.w2w) is None

    def draw(self, context: bpy.types.Context) -> None:
        layout = styled(self.layout, enabled=jobs.running is None)
        draw_activities(layout, state.polled_body(context).w2w, "Weight")


class W2W_PT_heatmap(ResultPanel, bpy.types.Panel):
    """Choice of the heatmap and its colours."""

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.w2w, "show_overlay", text="", icon="OVERLAY", emboss=False)

    def draw(self, context: bpy.types.Context) -> None:
        study = state.polled_body(context).w2w
        layout = styled(self.column(context), enabled=can_change_now(context), use_property_decorate=False)
        layout.prop(study, "view", text="")
        draw_activities(layout, study, "Weight, Best F1")
        layout.use_property_split = True
        is_double = scores.beside_of(study) is not None
        layout.operator("w2w.side_by_side", icon="MOD_MIRROR", depress=is_double)
        if is_double:
            column = layout.column(align=True)
            column.prop(study, "beside_view")
            if len(state.bodies(context.scene)) > 1:
                column.prop(study, "beside_body")
        else:
            layout.prop(study, "minus")
        layout.prop(study, "scores")
        if scores.minus_index(study) >= 0:  # a difference has colours of its own
            return
        layout.prop(study, "colour_map")
        layout.prop(study, "fix_range")
        if study.fix_range:
            row = styled(layout.row(align=True), use_property_split=False)
            row.prop(study, "range_low")
            row.prop(study, "range_high")
            row.operator("w2w.fit_range", text="", icon="FULLSCREEN_EXIT")


class W2W_OT_side_by_side(operators.OnRanking, bpy.types.Operator):
    """Show a second map on a copy of the body, both on one scale; press again to take it away"""

    bl_label = "Side by Side"

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        study, is_double = body.w2w, scores.beside_of(body.w2w) is not None
        if is_double:
            legend.remove(body)
        else:
            remove_source()  # it would stand where the copy does
            with state.without_updates():
                study.minus = scores.NOTHING  # a difference has a scale of its own
                study.beside = add_beside(body, body)
                if not study.is_property_set("beside_view"):  # at first another map than the body's
                    study.beside_view = scores.MEAN_VIEW if scores.view_index(study) else "A1"
        results.paint(body)
        if not is_double:  # painted, it stands in its place
            frame([body, study.beside])
            hide_others([body, study.beside])
        jobs.redraw(context)


class W2W_PT_regions(ResultPanel, bpy.types.Panel):
    """The best regions."""

    def draw(self, context: bpy.types.Context) -> None:
        study = state.polled_body(context).w2w
        layout = styled(self.column(context), enabled=can_change_now(context))
        draw_rows(layout, study, study.regions)


def draw_rows(layout: Layout, study: bpy.types.PropertyGroup, rows: bpy.types.bpy_prop_collection) -> None:
    """Draw a table of patches; a click on one looks at it."""
    column = layout.column(align=True)
    for entry in rows:
        row = column.row(align=True)
        split = row.split(factor=0.6 if entry.high > 0 else 0.7, align=True)
        draw_spot(split, study, entry, entry.label)
        value = styled(split.row(align=True), alignment="RIGHT")
        interval = f"{short(entry.f1)} ({short(entry.low)}–{short(entry.high)})"
        value.label(text=interval if entry.high > 0 else f"{entry.f1:.3f}", translate=False)


def draw_spot(layout: Layout, study: Group, entry: Group, text: str) -> None:
    """Draw the button that looks at the patch of a row, pressed while it is looked at."""
    is_picked = entry.patch in (study.picked, study.compared)
    layout.operator("w2w.select_patch", text=text, translate=False, depress=is_picked).patch = entry.patch
