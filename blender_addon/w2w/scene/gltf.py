# SPDX-License-Identifier: GPL-3.0-or-later
"""glTF, and VRM, which is made of it, through Blender's importer."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy

from ..core.motion.gltf_check import VRM_SUFFIXES, as_plain_glb, check_gltf

GLTF_RATE = 60
"""Frames per second that glTF is read at: it has times, no rate."""


def import_gltf(path: Path) -> None:
    """Import a glTF file into the open scene, finely enough for its key times.

    Raises
    ------
    UnusableMotion
        If it is damaged, of another version, lies in several files, or is no VRM though named as one.
    """
    is_vrm = path.suffix.lower() in VRM_SUFFIXES
    check_gltf(path, skin=not is_vrm)
    render = bpy.context.scene.render
    render.fps, render.fps_base = GLTF_RATE, 1.0
    if not is_vrm:
        bpy.ops.import_scene.gltf(filepath=str(path))
        return
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder, "vrm.glb")
        plain.write_bytes(as_plain_glb(path))
        bpy.ops.import_scene.gltf(filepath=str(plain))
