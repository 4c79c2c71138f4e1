# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's placements in the panel: the list, which of them are among the patches, and their scores.

Only placements in the patch set have signals and scores. Placing the patches again puts the whole list there.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy

from ...core.findings.summary import own_scores
from ...core.patches import own_placements as core
from ...core.patches.patches import PatchSet
from ...core.study.config import StudyConfig
from ...core.wording import plain_words
from ...scene.base.body import body_of
from ...scene.base.patches import empties_by_patch
from ...scene.files.study_file import pack
from ..study import lists, state
from . import results


def by_name(study: bpy.types.PropertyGroup) -> dict[str, int]:
    """The list: each placement's vertex by its name."""
    return {own.name: own.vertex for own in study.own}


def is_pending(study: bpy.types.PropertyGroup) -> bool:
    """Whether the list differs from the placements in the patch set."""
    return by_name(study) != dict(state.own_placed(study))


def patch_of_own(body: bpy.types.Object, own: bpy.types.PropertyGroup) -> int:
    """The patch of a placement, or -1 if it is not in the patch set."""
    patches = state.patches_of(body)
    if patches is None or (own.name, own.vertex) not in state.own_placed(body.w2w):
        return -1
    return patches.names.index(own.name)


def spot_name(study: bpy.types.PropertyGroup, patches: PatchSet, patch: int) -> str:
    """Words of a wish for a patch: its name if it is the user's placement, else its region."""
    own = {name for name, _ in state.own_placed(study)}
    return patches.names[patch] if patches.names[patch] in own else patches.regions[patch]


def scores_of_own(body: bpy.types.Object, own: bpy.types.PropertyGroup) -> dict[str, Any] | None:
    """A placement's `own_scores`, or None if it is not ranked."""
    utility, patches = state.utility_of(body.w2w), state.patches_of(body)
    if utility is None or patches is None or patch_of_own(body, own) < 0:
        return None
    names = [name for name, _ in state.own_placed(body.w2w)]
    base = lists.answer_of(body.w2w).get("costs_are_against") or [int(utility.expected_mean.argmax())]
    return own_scores(names, utility, patches, base)[names.index(own.name)]


def add(body: bpy.types.Object, name: str, vertex: int) -> None:
    """Add a placement to the list, and make it the active one; ValueError if name or vertex is taken."""
    _list(body, [*by_name(body.w2w).items(), (name, vertex)])
    body.w2w.own_index = len(body.w2w.own) - 1


def load(body: bpy.types.Object, path: Path) -> int:
    """Add the placements of a table, or move those whose names are listed; returns how many it holds.

    A table or placement that is not possible is a ValueError and leaves the list as it was.
    """
    found = core.placement_vertices(body_of(body), core.read_placements(path))
    known = {name.lower(): name for name in by_name(body.w2w)}
    moved = {known.get(name.lower(), name): vertex for name, vertex in found.items()}
    _list(body, (by_name(body.w2w) | moved).items())
    return len(found)


def rename(body: bpy.types.Object, own: bpy.types.PropertyGroup, name: str) -> None:
    """Give a placement another name, ValueError if that is taken: signals, scores and wishes follow."""
    study, before, number = body.w2w, own.name, patch_of_own(body, own)
    patches = state.patches_of(body)
    others = [other for other in study.own if other.name != before]
    vertices = [own.vertex, *(other.vertex for other in others)]
    name = core.check_names([name, *(other.name for other in others)], _taken(body, vertices))[0]
    with state.without_updates():
        own.name = own.title = name
        for wish in study.wishes:
            words = [part.strip() for part in wish.place.split(",")]
            if before in words:
                wish.place = ", ".join(name if word == before else word for word in words)
    if patches is not None and number >= 0 and name != before:
        placed = [(name if other == before else other, vertex) for other, vertex in state.own_placed(study)]
        _name_patch(study, patches, number, name)
        state.keep_own_placed(study, placed, state.sampled_patches(study, 0))
        results.choose(body)


def keep_placed(study: bpy.types.PropertyGroup, patches: PatchSet, config: StudyConfig) -> None:
    """List the user's placements that a run has among its patches."""
    known = [name.lower() for name in patches.names]
    found = [plain_words(name) for name, _ in config.placements]
    numbers = [known.index(name) for name in found if name in known]
    placed = [(patches.names[number], int(patches.vertices[number])) for number in numbers]
    _fill(study, placed)
    state.keep_own_placed(study, placed, config.patches)


def _taken(body: bpy.types.Object, vertices: Iterable[int]) -> list[str]:
    """Names of patches that are neither the user's placements nor at one of these vertices."""
    patches = state.patches_of(body)
    own = [vertex for _, vertex in state.own_placed(body.w2w)]
    return [] if patches is None else core.names_elsewhere(patches, [*own, *vertices])


def _list(body: bpy.types.Object, placements: Iterable[tuple[str, int]]) -> None:
    """Replace the list after validating names and distances."""
    names, vertices = zip(*placements, strict=True)
    names = core.check_names(names, _taken(body, vertices))
    core.check_apart(names, vertices)
    _fill(body.w2w, zip(names, vertices, strict=True))


def _fill(study: bpy.types.PropertyGroup, placements: Iterable[tuple[str, int]]) -> None:
    with state.without_updates():
        study.own.clear()
        for name, vertex in placements:
            own = study.own.add()
            own.name = own.title = name
            own.vertex = vertex


def _name_patch(study: bpy.types.PropertyGroup, patches: PatchSet, number: int, name: str) -> None:
    """Rename a patch; what was baked and ranked with it stays up to date."""
    baked, ranked = state.bake_settings(study), state.rank_settings(study)
    names = (*patches.names[:number], name, *patches.names[number + 1 :])
    study.patches_text, study.patches_key = pack(replace(patches, own_names=names))
    for clip in study.clips:
        if clip.baked_as == baked:
            clip.baked_as = state.bake_settings(study)
    if study.ranked_as == ranked:
        study.ranked_as = state.rank_settings(study)
    empty = empties_by_patch(study.patch_collection).get(number)
    if empty is not None:
        empty.name = name
