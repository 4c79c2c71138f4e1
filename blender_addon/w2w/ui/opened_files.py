# SPDX-License-Identifier: GPL-3.0-or-later
"""When a .blend file is opened, the runs in it become studies and find their signals; both outlive a move."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

from ..scene.study_record import has_record
from . import jobs, own_placements
from .listed_activities import list_labels
from .restore import find_folder, restore
from .state import bodies, current_body
from .step1_body import make_study
from .wishes import take_over


@bpy.app.handlers.persistent
def loaded(*_: object) -> None:
    """A file was opened: make studies of the runs in it, and find the signals of its studies."""
    jobs.dismiss()  # it was of the file before
    for mesh in [item for item in bpy.data.objects if item.type == "MESH" and item.library is None]:
        if mesh.w2w.is_body:
            take_over(mesh.w2w)
            own_placements.take_over(mesh.w2w)
            find_folder(mesh.w2w)
            list_labels(mesh.w2w)
        elif has_record(mesh):
            _restore(mesh)


@bpy.app.handlers.persistent
def saving(path: str, *_: object) -> None:
    """A file is being saved: note where, seen from it, the results are that its studies were opened from."""
    for scene in bpy.data.scenes if path else ():
        for body in bodies(scene):
            if body.library is None and body.w2w.results_folder:
                body.w2w.results_near = _seen_from(Path(path).parent, body.w2w.results_folder)


def _restore(mesh: bpy.types.Object) -> None:
    context = bpy.context
    try:
        text = restore(mesh)
    except ValueError as error:
        jobs.message = jobs.Message(f"The run in this file cannot be opened: {error}", True)
        return
    jobs.message = jobs.Message(text, False)
    if current_body(context) is None and context.scene.objects.get(mesh.name) is mesh:
        make_study(context, mesh)


def _seen_from(place: Path, folder: str) -> str:
    try:
        return os.path.relpath(folder, place)
    except ValueError:  # on another drive of Windows
        return ""


def register() -> None:
    """Look at every file that is opened or saved from now on, and soon at the one that is open."""
    bpy.app.handlers.load_post.append(loaded)
    bpy.app.handlers.save_pre.append(saving)
    if not bpy.app.background:
        bpy.app.timers.register(loaded, first_interval=0.0)  # while extensions start, no data can be seen


def unregister() -> None:
    """Take back what `register` did."""
    if bpy.app.timers.is_registered(loaded):
        bpy.app.timers.unregister(loaded)
    bpy.app.handlers.save_pre.remove(saving)
    bpy.app.handlers.load_post.remove(loaded)
