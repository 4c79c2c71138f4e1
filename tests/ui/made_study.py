# SPDX-License-Identifier: GPL-3.0-or-later
"""A study taken through its steps by their operators."""

from __future__ import annotations

import shutil
from pathlib import Path

import bpy

from w2w.ui.jobs import preferences

N_PATCHES = 48
ALL_STEPS = "motions patches signals utility"


def make_study(library: Path, steps: str = ALL_STEPS) -> bpy.types.Object:
    """A body taken through some steps; through all of them, it is saved the first time and opened later."""
    kept = library.with_name("finished study")
    if steps == ALL_STEPS and kept.is_dir():
        bpy.ops.wm.open_mainfile(filepath=str(kept / "study.blend"))
        shutil.copytree(kept / "cache", preferences.cache_folder(), dirs_exist_ok=True)
        return bpy.context.scene.w2w.body
    body = take_through(library, steps)
    if steps == ALL_STEPS:
        shutil.copytree(preferences.cache_folder(), kept / "cache")
        bpy.ops.wm.save_as_mainfile(filepath=str(kept / "study.blend"), copy=True)
    return body


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
        assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    return body


def names_in_file() -> dict[str, list[str]]:
    """Every object, collection, action and mesh."""
    data = bpy.data
    return {
        kind: sorted(getattr(data, kind).keys()) for kind in ("objects", "collections", "actions", "meshes")
    }
