# SPDX-License-Identifier: GPL-3.0-or-later
"""USD files: checked by USD's own library, then imported at their own time codes a second."""

import math
import sys
from pathlib import Path
from typing import Any

from ...core.motion.source import UnusableMotion, size_and_head
from ...core.wording import restated
from ..base.actions import set_scene_rate
from ..base.module import bpy, import_from

MAGICS = (b"#usda 1.", b"PXR-USDC", b"PK\x03\x04")
"""How text, binary and archive begin."""

FALLBACK_RATE = 24.0
"""Time codes a second if the file does not give them, by USD's own rule."""


def import_usd(path: Path) -> None:
    """Import a USD file, text or binary, at its own time codes a second, which Blender's importer ignores.

    Refused are files that are damaged or put together from others, and a Blender that knows no USD.
    """
    if "usd_import" not in dir(bpy.ops.wm):
        raise UnusableMotion("this Blender was built without USD: export the file as .glb or FBX")
    open_library()
    set_scene_rate(usd_rate(path))
    # what else would be read from beside it: textures, lights' pictures and volumes
    bpy.ops.wm.usd_import(
        filepath=str(path), import_materials=False, import_lights=False, import_volumes=False
    )


def open_library() -> None:
    """Let Python import USD's library, which Blender's module has off the path (4.4 and later)."""
    if bpy.app.module and "pxr" not in sys.modules:
        import_from(map(str, Path(bpy.__file__).parents[3].glob("python/lib/**/site-packages")), "pxr")


def usd_rate(path: Path) -> float:
    """Time codes a second of a USD file; one that is damaged or put together from other files is refused.

    Raises UnusableMotion, with the reason. No other file is opened.
    """
    if not size_and_head(path)[1].startswith(MAGICS):
        raise UnusableMotion("it is damaged or no USD file: it does not begin as one")
    try:
        from pxr import Sdf, Tf
    except ImportError:
        raise UnusableMotion(
            "whether other files are part of it cannot be seen here: use Blender 4.4 or later, or export it "
            "as .glb or FBX"
        ) from None
    with restated("it is damaged: USD cannot read it", Tf.ErrorException, UnusableMotion):
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    if layer is None:
        raise UnusableMotion("it is damaged: USD cannot read it")
    if part := next(filter(None, layer.GetCompositionAssetDependencies()), "") or _clips(layer):
        raise UnusableMotion(f"parts of it lie in other files ({part[:60]}): save it as one file, flattened")
    if layer.HasTimeCodesPerSecond():
        return _rate(layer.timeCodesPerSecond)
    return _rate(layer.framesPerSecond) if layer.HasFramesPerSecond() else FALLBACK_RATE


def _clips(layer: Any) -> str:
    """A prim whose values lie in other files, over time and without a reference (value clips); or ""."""
    found = list[str]()

    def look(path: Any) -> None:
        spec = layer.GetPrimAtPath(path)
        if spec is not None and spec.HasInfo("clips"):
            found.append(f"clips of {path}")

    layer.Traverse("/", look)
    return "".join(found[:1])


def _rate(rate: float) -> float:
    if not (math.isfinite(rate) and rate > 0):
        raise UnusableMotion(f"it is damaged: it has {rate:g} time codes a second")
    return rate
