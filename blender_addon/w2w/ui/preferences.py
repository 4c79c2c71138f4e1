# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences: where signals are kept and how many cores may work."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

EXTENSION = __package__.removesuffix(".blender_addon.w2w.ui")
"""Name under which Blender knows the extension; the package's own where it runs as a plain module."""

THREADS_VARIABLE = "OMP_NUM_THREADS"


def cache_folder() -> Path:
    """Folder for baked signals, made where it is missing: the chosen one, or the extension's own."""
    addon = bpy.context.preferences.addons.get(EXTENSION)
    chosen = addon.preferences.cache_folder if addon is not None else ""
    folder = Path(bpy.path.abspath(chosen)) if chosen else _own_folder()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _own_folder() -> Path:
    try:
        return Path(bpy.utils.extension_path_user(EXTENSION, path="signals", create=True))
    except ValueError:  # not installed as an extension, as in tests
        return Path(tempfile.gettempdir()) / "w2w-signals"


def _limit_threads(preferences: W2W_AddonPreferences, _context: bpy.types.Context) -> None:
    """core.threads and the matrix libraries read the number of threads from the environment."""
    if preferences.threads:
        os.environ[THREADS_VARIABLE] = str(preferences.threads)
    else:
        os.environ.pop(THREADS_VARIABLE, None)


class W2W_AddonPreferences(bpy.types.AddonPreferences):
    """Preferences of the W2W extension."""

    bl_idname = EXTENSION

    cache_folder: StringProperty(
        name="Signal Cache",
        description="Folder that baked signals are kept in, so that saved files open with them. "
        "Empty: the extension's own folder",
        subtype="DIR_PATH",
    )
    threads: IntProperty(
        name="Threads",
        description="How many processor cores may work on signals and rankings at the same time; 0 takes all",
        min=0,
        soft_max=32,
        update=_limit_threads,
    )

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the preferences."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "cache_folder")
        if not self.cache_folder:
            layout.label(text=f"Now {cache_folder()}", icon="BLANK1")
        layout.operator("w2w.clear_cache", icon="TRASH")
        layout.prop(self, "threads")


class W2W_OT_clear_cache(bpy.types.Operator):
    """Delete all baked signals from the cache folder; baking again brings back those in use"""

    bl_idname = "w2w.clear_cache"
    bl_label = "Clear Signal Cache"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask first."""
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Delete the files."""
        files = list(cache_folder().glob("*.w2w.npz"))
        size = sum(file.stat().st_size for file in files)
        for file in files:
            file.unlink(missing_ok=True)
        self.report({"INFO"}, f"Deleted {len(files)} files, {size / 1e6:.0f} MB")
        return {"FINISHED"}


def register() -> None:
    """Register, and let the saved number of threads apply."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    addon = bpy.context.preferences.addons.get(EXTENSION)
    if addon is not None and addon.preferences is not None and addon.preferences.threads:
        _limit_threads(addon.preferences, bpy.context)


def unregister() -> None:
    """Take back what `register` did."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


CLASSES = (W2W_AddonPreferences, W2W_OT_clear_cache)
