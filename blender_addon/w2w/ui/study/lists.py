# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of a study: its activities before there is a ranking, and a designer's wishes."""

from __future__ import annotations

import json

import bpy

from ...core.patches.body_parts import MIDDLE, PARTS, PLACEMENTS, PRODUCT_NAMED, SIDES, find_patches
from ...core.patches.patches import PatchSet
from ...core.study import StudyConfig
from .counting import list_activities
from .state import COST, FORBID, MUST, ONLY, run_of, usable, without_updates


def list_labels(study: bpy.types.PropertyGroup) -> None:
    """List the activities of a study's clips, unless a ranking lists its own; what they count stays."""
    if study.utility_key:
        return
    labels = sorted({clip.activity for clip in usable(study) if clip.activity.strip()})
    if labels == [activity.name for activity in study.activities]:
        return
    with without_updates():
        list_activities(study, labels, run_of(study))


def take_over(study: bpy.types.PropertyGroup) -> None:
    """List the wishes of the run that a study was opened from, where its parameters still hold them."""
    parameters = json.loads(study.parameters) if study.parameters else {}
    if "constraints" not in parameters:
        return
    constraints = StudyConfig.from_dict(parameters).constraints
    del parameters["constraints"]
    study.parameters = json.dumps(parameters)
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
    common = [*PRODUCT_NAMED, *(placement.name for placement in PLACEMENTS)]
    names = [*SIDES, MIDDLE, *PARTS, *sided, *common, *sorted(set(patches.regions)), *patches.names]
    words = typed.lower().split()
    return [name for name in dict.fromkeys(names) if all(word in name for word in words)]
