# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates that follow when a property of a study is changed; none inside `without_updates`."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ...core.wording import capital
from ...scene.base.body import armature_of
from ...scene.base.patches import patch_empties
from ...scene.base.patches import resize_patches as resize_empties
from ..jobs import jobs
from ..results import own_placements, results
from ..steps.patches import pick
from ..study import scores
from ..study.lists import list_labels
from ..study.state import is_silent, without_updates

Context = bpy.types.Context
Group = bpy.types.PropertyGroup


def _then_redraw(change: Callable[[bpy.types.Object], None]) -> Callable[[Group, Context], None]:
    """An update that changes the body whose study the property is of, and redraws."""

    def update(group: Group, context: Context) -> None:
        if not is_silent():
            change(group.id_data)
            jobs.redraw(context)

    return update


def relabel(clip: Group, _context: Context) -> None:
    """The motion's label travels with its action, and is among the activities."""
    if clip.action is not None:
        clip.action["activity"] = clip.activity
    if not is_silent():
        list_labels(clip.id_data.w2w)


def show_armature(study: Group, _context: Context) -> None:
    """Show or hide the bones."""
    armature_of(study.id_data).hide_set(not study.show_armature)


def resize_patches(study: Group, _context: Context) -> None:
    """Draw patches larger or smaller."""
    if study.patch_collection is not None:
        resize_empties(patch_empties(study.patch_collection), study.patch_size)
        results.mark_chosen(study.id_data)


def show_patches(study: Group, _context: Context) -> None:
    """Show or hide all patches; chosen sensors stay visible through their own collection."""
    results.hide_patches(study)


choose_patches = _then_redraw(results.choose)
repaint = _then_redraw(results.paint)


@_then_redraw
def reweigh(body: bpy.types.Object) -> None:
    """Count other activities in the mean and the choice."""
    results.paint(body)
    results.list_regions(body)
    results.choose(body)


@_then_redraw
def fix_range(body: bpy.types.Object) -> None:
    """One range for all heatmaps: the first time, the range of their scores."""
    study = body.w2w
    if study.fix_range and not any(study.is_property_set(name) for name in ("range_low", "range_high")):
        results.fit_range(body)
    else:
        results.paint(body)


@_then_redraw
def show_view(body: bpy.types.Object) -> None:
    """Show another heatmap."""
    study = body.w2w
    with without_updates():
        study.activity_index = scores.view_index(study) - 1
    if scores.minus_index(study) >= 0 or scores.beside_of(study) is not None:
        results.paint(body)
    else:
        results.show(body)


def view_activity(study: Group, _context: Context) -> None:
    """A click on an activity in the list shows its heatmap."""
    if not is_silent() and study.utility_key and 0 <= study.activity_index < len(study.activities):
        study.view = f"A{study.activity_index + 1}"


def redraw(_group: Group, context: Context) -> None:
    """Redraw every 3D view."""
    jobs.redraw(context)


def rename_placement(own: Group, context: Context) -> None:
    """Call a placement of one's own as typed, or say why that cannot be and leave it."""
    if is_silent() or own.title == own.name:
        return
    try:
        own_placements.rename(own.id_data, own, own.title)
    except ValueError as error:
        with without_updates():
            own.title = own.name
        jobs.message = jobs.Message(capital(error), True)
    else:
        jobs.dismiss_error()
    jobs.redraw(context)


def look_at_own(study: Group, context: Context) -> None:
    """A click on a placement of one's own looks at its patch, where it has one."""
    if is_silent() or not 0 <= study.own_index < len(study.own):
        return
    body, own = study.id_data, study.own[study.own_index]
    patch = own_placements.patch_of_own(body, own)
    if patch >= 0 and context.mode == "OBJECT":
        pick(context, body, patch, vertex=own.vertex)
    jobs.redraw(context)
