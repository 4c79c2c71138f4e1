# SPDX-License-Identifier: GPL-3.0-or-later
"""What a study's sensors were worn on besides the skin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..clip_files import FITTED
from ..patches.garment_cover import load_covers
from ..patches.patches import PatchSet


def garment_content(out: Path, garments: tuple[str, ...], patches: PatchSet) -> dict[str, Any]:
    """Each garment of a study, the patches that are on it and the regions that these lie in.

    Raises
    ------
    OSError, ValueError
        If the folder does not say what they cover.
    """
    if not garments:
        return {}
    covers = load_covers(out / FITTED)
    return {
        name: {
            "patches": covers[name].patches.tolist(),
            "regions": sorted({patches.regions[patch] for patch in covers[name].patches}),
        }
        for name in garments
    }


def garment_sentence(content: dict[str, Any], n_patches: int) -> str:
    """Where the sensors were, in a sentence; empty where all were on the skin."""
    if not content:
        return ""
    parts = [f"{len(own['patches'])} on {name}" for name, own in content.items()]
    on_skin = n_patches - sum(len(own["patches"]) for own in content.values())
    return (
        f"Of {n_patches} patches {', '.join(parts)} and {on_skin} on the skin. The cloth is simulated by "
        "Blender and has not yet been checked against worn garments"
    )
