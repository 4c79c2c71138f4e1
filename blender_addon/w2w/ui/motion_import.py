# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions into a study's list: files or an armature of the scene, retargeted to the body as actions."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import bpy

from ..core.file_names import shown
from ..core.motion.library import MOTION_SUFFIXES, LibraryError, activity_of, read_library, unique_names
from ..core.motion.source import UnusableMotion, reason_of
from ..scene.actions import write_action
from ..scene.body import armature_of, body_of
from ..scene.load import Carried, carry, read_motion
from .jobs import Step, Steps
from .on_body import on_body


class Wanted(NamedTuple):
    """A file to import and its labels."""

    path: Path
    name: str
    activity: str
    subject: str = ""


def wanted_in_folder(folder: Path) -> list[Wanted]:
    """The motion files of a folder, labelled by labels.csv, folder names or file names.

    Raises
    ------
    LibraryError
        If there are none, or labels.csv cannot be understood.
    """
    labels = folder / "labels.csv"
    library = read_library(folder, labels if labels.is_file() else None)
    return [Wanted(clip.path, clip.name, clip.activity, clip.subject) for clip in library.clips]


def wanted_files(paths: Iterable[Path]) -> list[Wanted]:
    """Single files, labelled by their names.

    Raises
    ------
    LibraryError
        If none of them is a motion file.
    """
    paths = [path for path in paths if path.suffix.lower() in MOTION_SUFFIXES]
    if not paths:
        raise LibraryError(f"choose motion files ({', '.join(MOTION_SUFFIXES)})")
    names = unique_names([path.name for path in paths])
    return [
        Wanted(path, name, activity_of(shown(path.name))) for path, name in zip(paths, names, strict=True)
    ]


@on_body
def import_steps(mesh: bpy.types.Object, wanted: list[Wanted]) -> Steps:
    """Import files one by one; a file that cannot be used stays in the list and says why."""
    body, armature = body_of(mesh), armature_of(mesh)
    before = len(mesh.w2w.clips)
    failed = 0
    finished = False
    try:
        for number, item in enumerate(wanted):
            yield Step(number / len(wanted), shown(item.path.name))
            try:
                carried = carry(read_motion(item.path), body)
                add_clip(mesh, armature, carried, item)
            except (UnusableMotion, ValueError) as error:
                failed += 1
                _add_failed(mesh, item, reason_of(error))
        finished = True
    finally:
        if not finished:
            remove_clips(mesh, range(before, len(mesh.w2w.clips)))
    mesh.w2w.clip_index = before
    used = len(wanted) - failed
    text = f"Imported {used} motion{'s' * (used != 1)}"
    return f"{text}; {failed} file{'s' * (failed != 1)} cannot be used: the list says why" if failed else text


def add_clip(
    mesh: bpy.types.Object, armature: bpy.types.Object, carried: Carried, item: Wanted
) -> bpy.types.PropertyGroup:
    """Write a motion as an action of the body and list it."""
    name = _free_name(mesh, item.name)
    motion = carried.motion.labelled(item.activity, item.subject, name)
    action = write_action(armature, motion, name)
    clip = mesh.w2w.clips.add()
    clip.name, clip.file, clip.subject = name, str(item.path), item.subject
    clip.action, clip.activity = action, item.activity
    clip.n_frames, clip.rate = motion.n_frames, motion.rate
    clip.skeleton, clip.scale = carried.skeleton, carried.scale
    return clip


def remove_clips(mesh: bpy.types.Object, indices: Iterable[int]) -> None:
    """Take clips off the list, with their actions."""
    study = mesh.w2w
    indices = sorted(indices, reverse=True)
    actions = [study.clips[index].action for index in indices]
    for index in indices:
        study.clips.remove(index)
    bpy.data.batch_remove([action for action in actions if action is not None])
    study.clip_index = min(max(study.clip_index, 0), max(len(study.clips) - 1, 0))


def _add_failed(mesh: bpy.types.Object, item: Wanted, reason: str) -> None:
    name = _free_name(mesh, shown(item.path.name))
    clip = mesh.w2w.clips.add()
    clip.name, clip.file, clip.problem = name, str(item.path), reason


def _free_name(mesh: bpy.types.Object, name: str) -> str:
    """A name that no clip of the list has: clips of one name would count as one motion."""
    taken, free, copy = set(mesh.w2w.clips.keys()), name, 1
    while free in taken:
        free, copy = f"{name} {copy:03d}", copy + 1
    return free
