# SPDX-License-Identifier: GPL-3.0-or-later
"""What a designer wishes for, in the words that people and the command line use."""

from __future__ import annotations

import json

import bpy

from ..core.patches.body_parts import MIDDLE, PARTS, SIDES, find_patches
from ..core.patches.patches import PatchSet
from ..core.patches.products import PLACEMENTS, PRODUCTS
from ..core.selection.constraints import Constraints
from ..core.study import StudyConfig
from .state import COST, FORBID, MUST, ONLY, without_updates

CONSTRAINTS = "constraints"
"""Where a run's parameters hold its wishes."""


def take_over(study: bpy.types.PropertyGroup) -> None:
    """List the wishes of the run that a study was opened from, where its parameters still hold them."""
    parameters = json.loads(study.parameters) if study.parameters else {}
    if CONSTRAINTS in parameters:
        list_wishes(study, StudyConfig.from_dict(parameters).constraints)
        del parameters[CONSTRAINTS]
        study.parameters = json.dumps(parameters)


def list_wishes(study: bpy.types.PropertyGroup, constraints: Constraints) -> None:
    """Fill the list of wishes."""
    with without_updates():
        study.wishes.clear()
        for kind, words in ((ONLY, constraints.only), (FORBID, constraints.forbid), (MUST, constraints.must)):
            for where in words:
                add_wish(study, kind, where)
        for where, cost in constraints.costs:
            wish = add_wish(study, COST, where)
            wish.cost, wish.given = cost, repr(cost)  # a property keeps single precision only


def add_wish(study: bpy.types.PropertyGroup, kind: str, place: str = "") -> bpy.types.PropertyGroup:
    """Add a wish at the end of the list."""
    with without_updates():
        wish = study.wishes.add()
        wish.kind, wish.place = kind, place
    return wish


def is_understood(patches: PatchSet, place: str) -> bool:
    """Whether all words of a wish mean something on a body."""
    try:
        for words in place.split(","):
            if words.strip():
                find_patches(patches.regions, patches.names, words)
    except ValueError:
        return False
    return True


def suggestions(patches: PatchSet, typed: str) -> list[str]:
    """Names that hold all that has been typed: sides, parts, products, placements, regions."""
    sided = [f"{side} {part}" for part in ("arm", "hand", "leg", "foot") for side in SIDES]
    common = [*PRODUCTS, *(placement.name for placement in PLACEMENTS)]
    names = [*SIDES, MIDDLE, *PARTS, *sided, *common, *sorted(set(patches.regions)), *patches.names]
    words = typed.lower().split()
    return [name for name in dict.fromkeys(names) if all(word in name for word in words)]
