# SPDX-License-Identifier: GPL-3.0-or-later
"""USD, as text or binary, through Blender's importer."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..core.motion.source import UnusableMotion
from ..core.motion.usd_check import check_usd
from .actions import set_scene_rate


def import_usd(path: Path) -> None:
    """Import a USD file into the open scene, at its own time codes a second, which the importer ignores.

    Raises
    ------
    UnusableMotion
        If it is damaged, put together from other files, or this Blender knows no USD.
    """
    if "usd_import" not in dir(bpy.ops.wm):
        raise UnusableMotion("this Blender was built without USD: export the file as .glb or FBX")
    with _bundled_modules():
        rate = check_usd(path)
    set_scene_rate(rate)
    bpy.ops.wm.usd_import(filepath=str(path), import_materials=False, import_lights=False)


@contextmanager
def _bundled_modules() -> Iterator[None]:
    """Let `pxr` be found in Blender's Python module, which brings it but leaves it off the path (4.4+)."""
    before = sys.path.copy()
    expose = getattr(bpy.utils, "expose_bundled_modules", None)
    if expose is not None:
        expose()
    try:
        yield
    finally:
        sys.path[:] = before
