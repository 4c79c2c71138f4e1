# SPDX-License-Identifier: GPL-3.0-or-later
"""A study taken through its steps by their operators, ranked roughly (`here.ROUGHLY`)."""

from __future__ import annotations

import shutil
from pathlib import Path

import bpy
from filelock import FileLock

from w2w.ui.jobs import preferences

from ..here import ranked_roughly

N_PATCHES = 24
ALL_STEPS = "motions patches signals utility"


def make_study(library: Path, steps: str = ALL_STEPS) -> bpy.types.Object:
    """A body taken through some steps; in an empty file, it is saved the first time and opened later."""
    if bpy.data.objects:
        return take_through(library, steps)
    kept = library.with_name(f"{library.name} {steps}")
    with FileLock(f"{kept}.lock"):
        if not (kept / "study.blend").is_file():
            take_through(library, steps)
            save_study(kept)
    return open_study(kept)


def save_study(folder: Path) -> None:
    """Save the file that is open and its signals."""
    shutil.copytree(preferences.cache_folder(), folder / "cache", dirs_exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "study.blend"), copy=True)


def open_study(folder: Path) -> bpy.types.Object:
    """The body of a saved file, with its signals."""
    bpy.ops.wm.open_mainfile(filepath=str(folder / "study.blend"))
    shutil.copytree(folder / "cache", preferences.cache_folder(), dirs_exist_ok=True)
    return bpy.context.scene.w2w.body


def take_through(library: Path, steps: str) -> bpy.types.Object:
    """A body taken through some steps by their operators."""
    assert bpy.ops.w2w.add_body() == {"FINISHED"}
    body = bpy.context.scene.w2w.body
    body.w2w.patch_count = N_PATCHES
    if "motions" in steps:
        assert bpy.ops.w2w.import_folder(directory=str(library)) == {"FINISHED"}
    if "patches" in steps:
        assert bpy.ops.w2w.place_patches() == {"FINISHED"}
    if "signals" in steps:
        assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    if "utility" in steps:
        with ranked_roughly():
            assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    return body


def names_in_file() -> dict[str, list[str]]:
    """Every object, collection, action and mesh."""
    data = bpy.data
    return {
        kind: sorted(getattr(data, kind).keys()) for kind in ("objects", "collections", "actions", "meshes")
    }
