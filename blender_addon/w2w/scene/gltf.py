# SPDX-License-Identifier: GPL-3.0-or-later
"""glTF through Blender's importer."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..core.motion.gltf_check import check_gltf

GLTF_RATE = 60
"""Frames per second that glTF is read at: it has times, no rate."""


def import_gltf(path: Path) -> None:
    """Import a glTF file into the open scene, finely enough for its key times.

    Raises
    ------
    UnusableMotion
        If it is damaged, of another version, or lies in several files.
    """
    check_gltf(path)
    render = bpy.context.scene.render
    render.fps, render.fps_base = GLTF_RATE, 1.0
    bpy.ops.import_scene.gltf(filepath=str(path))
