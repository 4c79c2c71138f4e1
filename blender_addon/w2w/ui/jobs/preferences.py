# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences: where signals are kept, how many cores may work."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

from ...core.study.clip_files import WORK
from ...core.threads import use_threads
from ...extension import NAME as EXTENSION

SIGNALS_SUFFIX = ".w2w"
"""Suffix of cached signals: the chosen folder may hold other files, even a run's."""


def _preferences() -> W2W_AddonPreferences | None:
    """The preferences as the user set them, or None if W2W does not run as an add-on."""
    return getattr(bpy.context.preferences.addons.get(EXTENSION), "preferences", None)


def cache_folder() -> Path:
    """The folder of baked signals, made if missing: the chosen one, or the extension's own."""
    preferences = _preferences()
    chosen = preferences.cache_folder if preferences is not None else ""
    if not chosen:
        return own_folder("signals")
    folder = Path(bpy.path.abspath(chosen))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def own_folder(name: str) -> Path:
    """A folder in the extension's own, made if missing."""
    try:
        return Path(bpy.utils.extension_path_user(EXTENSION, path=name, create=True))
    except ValueError:  # not installed as an extension, as in tests
        folder = Path(tempfile.gettempdir()) / f"w2w-{name}"
        folder.mkdir(exist_ok=True)
        return folder


def _limit_threads(preferences: W2W_AddonPreferences, _context: bpy.types.Context) -> None:
    use_threads(preferences.threads)


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
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "cache_folder")
        if not self.cache_folder:
            layout.label(text=f"Now {cache_folder()}", translate=False, icon="BLANK1")
        layout.operator("w2w.clear_cache", icon="TRASH")
        layout.prop(self, "threads")


class W2W_OT_clear_cache(bpy.types.Operator):
    """Delete all baked signals from the cache folder; baking again brings back those in use"""

    bl_idname = "w2w.clear_cache"
    bl_label = "Clear Signal Cache"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        folders = (cache_folder() / "signals", cache_folder() / WORK / "features")
        files = [file for folder in folders for file in folder.glob(f"*{SIGNALS_SUFFIX}.npz")]
        size = sum(file.stat().st_size for file in files)
        for file in files:
            file.unlink(missing_ok=True)
        self.report({"INFO"}, f"Deleted {len(files)} files, {size / 1e6:.0f} MB")
        return {"FINISHED"}


def register() -> None:
    """Let what was saved apply."""
    preferences = _preferences()
    if preferences is not None:
        use_threads(preferences.threads)


def unregister() -> None:
    """Take back what `register` did."""
    use_threads(0)
