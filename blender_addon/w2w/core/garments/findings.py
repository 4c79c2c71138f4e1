# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that a study's sensors were worn on, and cloth that caught."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..patches.patches import PatchSet
from .caught import caught_sentence
from .cover import FITTED, load_covers

CLIPS_NAMED = 3
"""Clips with cloth that caught that are named."""


def garment_content(out: Path, garments: tuple[str, ...], patches: PatchSet) -> dict[str, Any]:
    """Each garment of a study, the patches that are on it and the regions that these lie in."""
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


def caught_content(frames: Mapping[str, int], of: int) -> dict[str, Any]:
    """Cloth that caught on the body, for a clip's record; empty where none did.

    From the number of frames in which each garment had caught, of all frames of the clip.
    """
    found = {name: count for name, count in frames.items() if count}
    return {"cloth_caught": found, "cloth_frames": of} if found else {}


def caught_sentences(clips: Sequence[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """A sentence for each of the first clips in which cloth caught, and one for the rest.

    From each clip's name and its record's details.
    """
    found = [(name, about) for name, about in clips if about.get("cloth_caught")]
    sentences = [
        f"In {name} {caught_sentence(about['cloth_caught'], about['cloth_frames'])}: do not trust what its "
        "sensors feel there"
        for name, about in found[:CLIPS_NAMED]
    ]
    more = len(found) - CLIPS_NAMED
    if more > 0:
        clips = f"{more} more clip{'s' * (more > 1)}"
        sentences.append(f"Cloth caught in {clips}: see cloth_caught in summary.json")
    return sentences
