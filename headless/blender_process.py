# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender in this process: the `bpy` module, or the program W2W was started from."""

from __future__ import annotations

import sys
from pathlib import Path


def inside_blender() -> bool:
    """Whether this is the Blender program, whose Python cannot start workers with `bpy`."""
    return bool(sys.modules.get("bpy")) and bool(sys.modules["bpy"].app.binary_path)


def forget_scripts_path() -> None:
    """Let a fresh worker find the `bpy` module.

    Importing `bpy` puts Blender's scripts folder on the path, with a package `bpy` in it that
    needs the module loaded first; workers inherit the path but not the module.
    """
    if "bpy" not in sys.modules:
        sys.path[:] = [entry for entry in sys.path if not _is_scripts_folder(Path(entry))]


def _is_scripts_folder(folder: Path) -> bool:
    return folder.parts[-2:] == ("scripts", "modules") and (folder / "bpy" / "__init__.py").is_file()
