# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the rows of a study's lists, and the updates that follow when one of a study is changed."""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ...core.findings.notes import merged_sentence
from ...core.patches.body_parts import suggestions
from ...core.wording import capital
from ...scene import heatmap
from ...scene.base.body import armature_of
from ...scene.base.patches import patch_empties
from ..jobs import jobs
from ..results import own_placements, results
from ..steps.patches import pick
from ..study import counting, lists, scores, state
from ..study.counting import Group
from ..viewport import legend

KINDS = (
    (state.ONLY, "Only", "Sensors go here, or into the other regions marked Only, and nowhere else"),
    (state.FORBID, "Forbid", "No sensor goes here"),
    (state.MUST, "Must", "At least one sensor goes here"),
    (state.COST, "Cost", "A sensor here costs this much, in money or in comfort; elsewhere it costs 1"),
)

PARTS = (
    (counting.COUNTED, "Counted", "Count it in the mean and in the choice of sensors, by its weight",
     "CHECKBOX_HLT", 0),
    (counting.BACKGROUND, "Background", "Do not confuse it with the others: trained against, but in no mean",
     "SELECT_SUBTRACT", 1),
    (counting.LEFT_OUT, "Left Out", "Do as if it had not been there", "CHECKBOX_DEHLT", 2),
)  # fmt: skip


def _then_redraw(change: Callable[[bpy.types.Object], None]) -> Callable[[Group, bpy.types.Context], None]:
    """An update, none in `without_updates`, that changes the body of the property's study and redraws."""

    def update(group: Group, context: bpy.types.Context) -> None:
        if not state.is_silent():
            change(group.id_data)
            jobs.redraw(context)

    return update


def relabel(clip: Group, _context: bpy.types.Context) -> None:
    """Spell the label like the listed activities, note it on the action, and list it."""
    spell(clip, "activity")
    if clip.action is not None:
        clip.action["activity"] = clip.activity
    if not state.is_silent():
        lists.list_labels(clip.id_data.w2w)


def spell_subject(clip: Group, _context: bpy.types.Context) -> None:
    """Spell the subject like the other clips'."""
    spell(clip, "subject")


def spell(clip: Group, what: str) -> None:
    """Spell a typed label like the other clips', and say so."""
    study, typed = clip.id_data.w2w, getattr(clip, what)
    spelled = typed if state.is_silent() else lists.listed_spelling(study, typed, what, {clip.name})
    if spelled == typed:
        return
    with state.without_updates():
        setattr(clip, what, spelled)
    if typed.strip() != spelled:
        jobs.message = jobs.Message(capital(merged_sentence(spelled, (spelled, typed), what)), False)


def show_armature(study: Group, _context: bpy.types.Context) -> None:
    """Show or hide the bones."""
    armature_of(study.id_data).hide_set(not study.show_armature)


def resize_patches(study: Group, _context: bpy.types.Context) -> None:
    """Draw patches larger or smaller."""
    if study.patch_collection is not None:
        for empty in patch_empties(study.patch_collection):
            empty.empty_display_size = study.patch_size
        results.mark_chosen(study.id_data)


def show_patches(study: Group, _context: bpy.types.Context) -> None:
    """Show or hide all patches; chosen sensors stay visible through their own collection."""
    results.hide_patches(study)


choose_patches = _then_redraw(results.choose)
compare_places = _then_redraw(results.compare_places)
repaint = _then_redraw(results.paint)


@_then_redraw
def reweigh(body: bpy.types.Object) -> None:
    """Count other activities in the mean and the choice."""
    results.paint(body)
    results.choose(body)


@_then_redraw
def fix_range(body: bpy.types.Object) -> None:
    """Give all heatmaps one range: the first time, the range of their scores."""
    study = body.w2w
    if study.fix_range and not any(study.is_property_set(name) for name in ("range_low", "range_high")):
        results.fit_range(body)
    else:
        results.paint(body)


@_then_redraw
def show_view(body: bpy.types.Object) -> None:
    """Show another heatmap."""
    study = body.w2w
    with state.without_updates():
        study.activity_index = scores.view_index(study) - 1
    if scores.minus_index(study) >= 0 or scores.beside_of(study) is not None:
        results.paint(body)
    else:
        results.show(body)


def view_activity(study: Group, _context: bpy.types.Context) -> None:
    """Show the heatmap of the activity that was clicked."""
    if not state.is_silent() and study.utility_key and 0 <= study.activity_index < len(study.activities):
        study.view = f"A{study.activity_index + 1}"


def redraw(_group: Group, context: bpy.types.Context) -> None:
    """Redraw every 3D view."""
    jobs.redraw(context)


def rename_placement(own: Group, context: bpy.types.Context) -> None:
    """Rename the user's placement, or show why the name is refused and restore the old one."""
    if state.is_silent() or own.title == own.name:
        return
    try:
        own_placements.rename(own.id_data, own, own.title)
    except ValueError as error:
        with state.without_updates():
            own.title = own.name
        jobs.message = jobs.Message(capital(error), True)
    else:
        jobs.dismiss_error()
    jobs.redraw(context)


def look_at_own(study: Group, context: bpy.types.Context) -> None:
    """Look at the patch of the placement that was clicked, if it has one."""
    if state.is_silent() or not 0 <= study.own_index < len(study.own):
        return
    body, own = study.id_data, study.own[study.own_index]
    patch = own_placements.patch_of_own(body, own)
    if patch >= 0 and context.mode == "OBJECT":
        pick(context, body, patch, vertex=own.vertex)
    jobs.redraw(context)


def show_on_mesh(item: W2W_PG_character_mesh, _context: bpy.types.Context) -> None:
    """Show the map on a character's mesh, or no longer; the sensors stay on those that show it."""
    body = item.id_data
    if not item.use and item.mesh is not None:
        heatmap.remove_heatmaps(item.mesh)
    legend.paint_character(body)
    legend.show_on_character(body)
    results.mark_chosen(body)


class W2W_PG_clip(Group):
    """A motion in a study's list."""

    name: StringProperty(name="Clip", description="Name of the clip")
    file: StringProperty(name="File", description="File the motion was read from", subtype="FILE_PATH")
    activity: StringProperty(
        name="Activity",
        description="What the motion shows; clips with the same label are one activity",
        update=relabel,
    )
    subject: StringProperty(name="Subject", description="Who moves, if known", update=spell_subject)
    action: PointerProperty(type=bpy.types.Action, name="Action", description="The motion on the body")
    n_frames: IntProperty(name="Frames", description="Frames of the motion")
    rate: FloatProperty(name="Frame Rate", description="Frames per second of the motion")
    animation: StringProperty(options={"HIDDEN"})  # the one that it is, of a file that holds several
    given_rate: FloatProperty(options={"HIDDEN"})  # at its import; 0 where the file's own is right
    given_up: StringProperty(options={"HIDDEN"})  # the axis that is up, where the format does not say it
    skeleton: StringProperty(name="Skeleton", description="Naming that the file's bones follow")
    scale: FloatProperty(name="Scale", description="Body metres in one unit of the file", default=1.0)
    selected: BoolProperty(name="Select", description="Take part in Relabel, Remove and Bake Selected")
    signals: StringProperty(name="Signals", description="Key of the baked signals")
    baked_as: StringProperty(name="Baked As", description="Settings that the signals were baked with")
    bake_path: StringProperty(name="Bake Path", description="How the surface was read, and why")
    problem: StringProperty(name="Problem", description="Why this file cannot be used")
    taken_from: StringProperty(
        name="Taken From", description="Armature and action of the scene that the motion was taken from"
    )
    motion_key: StringProperty(name="Motion", description="Clips with the same key show the same motion")
    source_sha256: StringProperty(options={"HIDDEN"})
    facts: StringProperty(options={"HIDDEN"})  # what only some clips' records say, such as frames cut off
    stored_as: StringProperty(name="Stored As", description="Name of its files in the results folder")


class W2W_PG_activity(Group):
    """An activity of the clips, or of their ranking."""

    name: StringProperty(name="Activity")
    part: EnumProperty(name="Part", description="What this activity counts", items=PARTS, update=reweigh)
    weight: FloatProperty(
        name="Weight",
        description="What this activity counts in the mean, against 1 for the others; 0 is background",
        default=1.0, min=0.0, soft_max=10.0, precision=2, step=10, update=reweigh,
    )  # fmt: skip
    given: StringProperty(options={"HIDDEN"})


def _suggest(wish: W2W_PG_wish, _context: bpy.types.Context, typed: str) -> list[str]:
    """Parts, products and patches whose names contain what was typed."""
    patches = state.patches_of(wish.id_data)
    return suggestions(patches.regions, patches.names, typed) if patches is not None else []


class W2W_PG_place(Group):
    """A patch in a table of results."""

    patch: IntProperty(name="Spot")
    label: StringProperty(name="Name")
    f1: FloatProperty(name="F1")
    low: FloatProperty(name="Lower Limit")
    high: FloatProperty(name="Upper Limit")
    is_open: BoolProperty(name="Card", description="Show where this sensor goes, in words")


class W2W_PG_wish(Group):
    """A wish of a designer's."""

    kind: EnumProperty(
        name="Wish",
        description="What is wished for",
        items=KINDS,
        default=state.FORBID,
        update=choose_patches,
    )
    place: StringProperty(
        name="Place",
        description="A side (left, right, middle), a part of the body (head, left arm), a region (left "
        "wrist), a product (watch, belt) or a spot; several are separated by commas",
        search=_suggest,
        search_options={"SUGGESTION"},
        update=choose_patches,
    )
    cost: FloatProperty(
        name="Cost",
        description="Price or discomfort of a sensor there; elsewhere it is 1",
        default=2.0, min=1e-6, soft_min=0.1, soft_max=10.0, precision=2, update=choose_patches,
    )  # fmt: skip
    given: StringProperty(options={"HIDDEN"})


class W2W_PG_own(Group):
    """A placement of the user's."""

    name: StringProperty(name="Name", description="What it is called", options={"HIDDEN"})
    title: StringProperty(
        name="Name", description="What you call this placement; wishes may name it", update=rename_placement
    )
    vertex: IntProperty(name="Vertex", description="Vertex of the body that it is at")


class W2W_PG_cover(Group):
    """What is worn on the body, so that sensors sit on it."""

    item: PointerProperty(type=bpy.types.Object, name="Worn")


class W2W_PG_character_mesh(Group):
    """A mesh of a character."""

    mesh: PointerProperty(type=bpy.types.Object, name="Mesh")
    use: BoolProperty(
        name="Use",
        description="Show the map and the sensors on this mesh: leave out clothes, hair or what is held",
        default=True,
        update=show_on_mesh,
    )
