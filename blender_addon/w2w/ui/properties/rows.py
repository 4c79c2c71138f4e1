# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the rows of a study's lists: clips, activities, placements, wishes and results."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..study import counting
from ..study.lists import suggestions
from ..study.state import COST, FORBID, MUST, ONLY, patches_of, without_updates
from . import updates

KINDS = (
    (ONLY, "Only", "Sensors go here, or into the other regions marked Only, and nowhere else"),
    (FORBID, "Forbid", "No sensor goes here"),
    (MUST, "Must", "At least one sensor goes here"),
    (COST, "Cost", "A sensor here costs this much, in money or in comfort; elsewhere it costs 1"),
)

PARTS = (
    (
        counting.COUNTED,
        "Counted",
        "Count it in the mean and in the choice of sensors, by its weight",
        "CHECKBOX_HLT",
        0,
    ),
    (
        counting.BACKGROUND,
        "Background",
        "Do not confuse it with the others: trained against, but in no mean",
        "SELECT_SUBTRACT",
        1,
    ),
    (counting.LEFT_OUT, "Left Out", "Do as if it had not been there", "CHECKBOX_DEHLT", 2),
)


class W2W_PG_clip(bpy.types.PropertyGroup):
    """A motion in a study's list."""

    name: StringProperty(name="Clip", description="Name of the clip")
    file: StringProperty(name="File", description="File the motion was read from", subtype="FILE_PATH")
    activity: StringProperty(
        name="Activity",
        description="What the motion shows; clips with the same label are one activity",
        update=updates.relabel,
    )
    subject: StringProperty(name="Subject", description="Who moves, where that is known")
    action: PointerProperty(type=bpy.types.Action, name="Action", description="The motion on the body")
    n_frames: IntProperty(name="Frames", description="Frames of the motion")
    rate: FloatProperty(name="Frame Rate", description="Frames per second of the motion")
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
    motion_key: StringProperty(
        name="Motion", description="Clips of an equal key show the same motion; empty where nothing is known"
    )
    source_sha256: StringProperty(options={"HIDDEN"})
    stored_as: StringProperty(name="Stored As", description="Name of its files in the results folder")


def _part(activity: W2W_PG_activity) -> int:
    return [name for name, *_ in PARTS].index(counting.part_of(activity))


def _set_part(activity: W2W_PG_activity, number: int) -> None:
    with without_updates():  # the part's own update follows
        counting.set_part(activity, PARTS[number][0])


class W2W_PG_activity(bpy.types.PropertyGroup):
    """An activity of the clips, or of their ranking."""

    name: StringProperty(name="Activity")
    use: BoolProperty(name="Use", description="Not left out", default=True, update=updates.reweigh)
    background: BoolProperty(
        name="Background", description="Trained against, and in no mean", update=updates.reweigh
    )
    part: EnumProperty(
        name="Part",
        description="What this activity counts",
        items=PARTS,
        get=_part,
        set=_set_part,
        update=updates.reweigh,
    )
    weight: FloatProperty(
        name="Weight",
        description="What this activity counts in the mean, beside 1 for the others; 0 is background",
        default=1.0,
        min=0.0,
        soft_max=10.0,
        precision=2,
        step=10,
        update=updates.reweigh,
    )
    given: StringProperty(options={"HIDDEN"})


def _suggest(wish: W2W_PG_wish, _context: bpy.types.Context, typed: str) -> list[str]:
    """Parts, products and patches whose names hold what has been typed."""
    patches = patches_of(wish.id_data)
    return suggestions(patches, typed) if patches is not None else []


class W2W_PG_place(bpy.types.PropertyGroup):
    """A patch in a table of results."""

    patch: IntProperty(name="Patch")
    label: StringProperty(name="Name")
    f1: FloatProperty(name="F1")
    low: FloatProperty(name="Lower Limit")
    high: FloatProperty(name="Upper Limit")


class W2W_PG_wish(bpy.types.PropertyGroup):
    """A wish of a designer's."""

    kind: EnumProperty(
        name="Wish",
        description="What is wished for",
        items=KINDS,
        default=FORBID,
        update=updates.choose_patches,
    )
    place: StringProperty(
        name="Place",
        description="A side (left, right, middle), a part of the body (head, left arm), a region (left "
        "wrist), a product (watch, belt) or a patch; several are separated by commas",
        search=_suggest,
        search_options={"SUGGESTION"},
        update=updates.choose_patches,
    )
    cost: FloatProperty(
        name="Cost",
        description="Price or discomfort of a sensor there; elsewhere it is 1",
        default=2.0,
        min=1e-6,
        soft_min=0.1,
        soft_max=10.0,
        precision=2,
        update=updates.choose_patches,
    )
    given: StringProperty(options={"HIDDEN"})


class W2W_PG_own(bpy.types.PropertyGroup):
    """A placement of one's own."""

    name: StringProperty(name="Name", description="What it is called", options={"HIDDEN"})
    title: StringProperty(
        name="Name",
        description="What you call this placement; wishes may name it",
        update=updates.rename_placement,
    )
    vertex: IntProperty(name="Vertex", description="Vertex of the body that it is at")
