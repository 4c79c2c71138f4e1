# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the choice of sensors: what is wished for, and what was chosen."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)

from . import updates
from .declared import declared
from .listed import suggestions
from .state import COST, FORBID, MUST, ONLY, patches_of

KINDS = (
    (ONLY, "Only", "Sensors go here, or into the other regions marked Only, and nowhere else"),
    (FORBID, "Forbid", "No sensor goes here"),
    (MUST, "Must", "At least one sensor goes here"),
    (COST, "Cost", "A sensor here costs this much, in money or in comfort; elsewhere it costs 1"),
)

FIRST_LIMIT = 3
"""Most sensors, when a limit is switched on."""


def _suggest(wish: W2W_PG_wish, _context: bpy.types.Context, typed: str) -> list[str]:
    """Parts, products and patches whose names hold what has been typed."""
    patches = patches_of(wish.id_data)
    return suggestions(patches, typed) if patches is not None else []


def _is_limited(study: Placement) -> bool:
    return study.max_places > 0


def _limit(study: Placement, limited: bool) -> None:
    study.max_places = FIRST_LIMIT if limited else 0


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


class Placement:
    """The part of a study's properties that chooses sensors."""

    target: FloatProperty(**declared("target"), precision=2, subtype="FACTOR", update=updates.choose_patches)
    every_activity: FloatProperty(
        **declared("every_activity"), precision=2, subtype="FACTOR", update=updates.choose_patches
    )
    max_places: IntProperty(**declared("max_places"), soft_max=12, update=updates.choose_patches)
    limit_places: BoolProperty(
        name="Limit",
        description="Limit the number of sensors",
        get=_is_limited,
        set=_limit,
    )
    own: CollectionProperty(type=W2W_PG_own)
    own_index: IntProperty(
        name="Active Placement",
        description="The placement of yours that is looked at",
        update=updates.look_at_own,
    )
    own_placed: StringProperty(options={"HIDDEN"})
    wishes: CollectionProperty(type=W2W_PG_wish)
    verdict: StringProperty(
        name="Verdict", description="The best spot that wishes leave, or why there is none"
    )
    chosen: CollectionProperty(type=W2W_PG_place)
    worn: CollectionProperty(type=W2W_PG_place)
    advice_text: StringProperty(options={"HIDDEN"})
    advised_as: StringProperty(options={"HIDDEN"})
    regions: CollectionProperty(type=W2W_PG_place)


CLASSES = (W2W_PG_place, W2W_PG_own, W2W_PG_wish)
