# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens by itself when people undo, leave Edit Mode, delete a body, open or save a file."""

import bpy

from ...scene.base.patches import lost_empties
from ...scene.body.character import lost_marks
from ...scene.heatmap import BESIDE, remove_beside
from ..jobs import jobs
from ..results import results
from ..study import state
from ..study.pages import ANSWER, CLIPS, turn_to
from ..viewport.framing import fold_soon, go_with
from ..viewport.legend import show_colours
from . import open_results

BUSY = 0.5
"""Seconds until the next look whether a job has ended."""

_counts: dict[str, int] = {}
"""Number of objects of each scene at the last look."""


_placed: set[int] = set()
"""Collections of patches before undo or redo."""


@bpy.app.handlers.persistent
def undoing(*_: object) -> None:
    """Note which patches there are before undo or redo."""
    _placed.clear()
    _placed.update(_patch_collections())


@bpy.app.handlers.persistent
def undone(*_: object) -> None:
    """After undo or redo, clear the panel's message, which is out of date; fold patches that came back."""
    if jobs.running is None:
        jobs.dismiss()
    if _patch_collections() - _placed:
        fold_soon()


def _patch_collections() -> set[int]:
    bodies = (body for scene in bpy.data.scenes for body in state.bodies(scene))
    return {home.session_uid for body in bodies if (home := body.w2w.patch_collection) is not None}


@bpy.app.handlers.persistent
def loaded(*_: object) -> None:
    """A file was opened: scenes of the same name are others now, and an answer in it is shown."""
    _counts.clear()
    body = state.current_body(bpy.context)
    turn_to(ANSWER if body is not None and state.is_ranked(body) else CLIPS)
    if _patch_collections():
        fold_soon()  # without the file's own windows, or in those of another version, they would unfold


@bpy.app.handlers.persistent
def updated(scene: bpy.types.Scene, *_: object) -> None:
    """After a change of the scene, paint what waited; follow bodies that were deleted or brought in."""
    results.paint_waiting()
    count, before = len(scene.objects), _counts.get(scene.name, 0)
    for is_due, follow in ((count < before, take_along), (count > before, take_up)):
        if is_due and not bpy.app.timers.is_registered(follow):
            bpy.app.timers.register(follow, first_interval=0.0)  # nothing may be changed in a handler
    _counts[scene.name] = count


@bpy.app.handlers.persistent
def went(*_: object) -> None:
    """At another frame of a clip, 3D views go with the body: it would walk out of them."""
    body = state.current_body(bpy.context)
    if jobs.running is None and body is not None and not bpy.app.is_job_running("RENDER"):
        go_with(body, state.playing_clip(body) is not None)


def take_up() -> float | None:
    """Let the panel work on a body that was appended or linked, if it works on none."""
    if jobs.running is not None:
        return BUSY
    for scene in bpy.data.scenes:
        brought = state.bodies(scene) if scene.library is None and scene.w2w.body is None else []
        for body in brought[:1]:
            scene.w2w.body = body
            patches = body.w2w.patch_collection
            if patches is not None and patches not in scene.collection.children_recursive:
                body.users_collection[0].children.link(patches)
            if body.w2w.utility_key:
                show_colours()
            fold_soon()
    return None


def take_along() -> float | None:
    """Remove what deleted bodies leave: patches, sensors on characters, second bodies."""
    if jobs.running is not None:
        return BUSY
    # collections hold whatever was not deleted; one that is unlinked can be linked again
    collections = (*bpy.data.collections, *(scene.collection for scene in bpy.data.scenes))
    kept = {item for home in collections for item in home.objects}
    shown = {item.w2w.beside for item in kept if item.type == "MESH"}
    copies = [item for item in bpy.data.objects if BESIDE in item and item.library is None]
    beside = [item for item in copies if item not in shown]
    marks = {item.w2w.marks for item in kept if item.type == "MESH"}
    lost = {*lost_empties(kept), *lost_marks(marks)}
    homes = {collection for item in lost for collection in item.users_collection}
    emptied = [home for home in homes if not home.children and lost.issuperset(home.objects)]
    bpy.data.batch_remove([*lost, *emptied])
    remove_beside(beside)
    for scene in bpy.data.scenes:
        if scene.library is None and scene.w2w.body is not None and scene.w2w.body not in kept:
            scene.w2w.body = None
    return None


HANDLERS = (
    (bpy.app.handlers.undo_pre, undoing),
    (bpy.app.handlers.redo_pre, undoing),
    (bpy.app.handlers.undo_post, undone),
    (bpy.app.handlers.redo_post, undone),
    (bpy.app.handlers.load_post, open_results.loaded),
    (bpy.app.handlers.load_post, loaded),
    (bpy.app.handlers.save_pre, open_results.saving),
    (bpy.app.handlers.depsgraph_update_post, updated),
    (bpy.app.handlers.frame_change_post, went),
)


def register() -> None:
    """Follow from now on, and look soon at the open file."""
    for handlers, follow in HANDLERS:
        handlers.append(follow)
    if not bpy.app.background:  # while extensions start, no data can be seen
        bpy.app.timers.register(open_results.loaded, first_interval=0.0)


def unregister() -> None:
    """Follow no more."""
    for follow in filter(bpy.app.timers.is_registered, (take_along, take_up, open_results.loaded)):
        bpy.app.timers.unregister(follow)
    for handlers, follow in HANDLERS:
        handlers.remove(follow)
    _counts.clear()
