# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches that words mean: a side, a part of the body, a product, a region, as people wish for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..wording import plain_words
from .products import PLACEMENTS, PRODUCTS

HEAD = (
    "ear", "behind ear", "back of head", "cheek", "chin", "eye", "forehead", "jaw", "mouth", "nose",
    "scalp crown", "side of head", "temple",
)  # fmt: skip
NECK = ("nape", "neck", "throat")
HAND = (
    "back of hand", "hand little finger side", "hand thumb side", "index finger", "little finger",
    "middle finger", "ring finger", "palm", "thumb",
)  # fmt: skip
ARM = (
    "shoulder back", "shoulder front", "shoulder lateral", "shoulder top",
    "upper arm back", "upper arm front", "upper arm lateral", "upper arm medial",
    "elbow back", "elbow front", "elbow lateral", "elbow medial",
    "forearm dorsal", "forearm little finger side", "forearm thumb side", "forearm volar",
    "wrist dorsal", "wrist little finger side", "wrist thumb side", "wrist volar",
)  # fmt: skip
FOOT = ("foot lateral", "foot medial", "heel", "instep", "sole", "toes")
LEG = (
    "thigh back", "thigh front", "thigh lateral", "thigh medial",
    "knee back", "knee front", "knee lateral", "knee medial",
    "calf", "shin", "lower leg lateral", "lower leg medial",
    "ankle back", "ankle front", "ankle lateral", "ankle medial",
)  # fmt: skip
BACK = (
    "lower back",
    "lower spine",
    "middle back",
    "middle spine",
    "posterior scapula",
    "sacrum",
    "upper spine",
)
CHEST = ("chest", "sternum")
FRONT_AND_SIDES = (
    "abdomen", "lower abdomen", "upper abdomen", "armpit", "buttock", "collarbone", "front hip",
    "front pocket", "front ribs", "groin", "hip", "lateral oblique", "navel", "side ribs",
)  # fmt: skip

PARTS: dict[str, tuple[str, ...]] = {
    "head": HEAD,
    "neck": NECK,
    "torso": (*BACK, *CHEST, *FRONT_AND_SIDES),
    "back": BACK,
    "chest": CHEST,
    "arm": (*ARM, *HAND),
    "hand": HAND,
    "leg": (*LEG, *FOOT),
    "foot": FOOT,
}
"""Regions of each part, without their side. An arm includes its hand and a leg its foot."""

ALL = (*HEAD, *NECK, *PARTS["torso"], *PARTS["arm"], *PARTS["leg"])
"""Every region, without its side."""

SIDES = ("left", "right")
MIDDLE = "middle"
"""Where the body has but one: sternum, spine, navel, nose."""


def find_patches(regions: Sequence[str], names: Sequence[str], wish: str) -> np.ndarray:
    """Patches that a person's words mean.

    Parameters
    ----------
    regions : sequence of str, length N
        Region of each patch, as in `PatchSet.regions`.
    names : sequence of str, length N
        Name of each patch, as in `PatchSet.names`.
    wish : str
        A side ("left", "right", "middle": on neither), a part of the body with or without its
        side ("head", "left arm"), a product ("belt", "right shoe"), a patch's own name, words of a
        region's name ("left wrist", "pocket"), or one of the 11 placements ("waist").

    Returns
    -------
    ndarray of int
        None where the words are understood but no patch lies there.

    Raises
    ------
    ValueError
        If nothing on a body is called that.
    """
    words = plain_words(wish)
    known = [name.lower() for name in names]
    if words in known:
        return np.array([known.index(words)])
    if words == MIDDLE:
        return np.array([patch for patch, region in enumerate(regions) if not _side(region)], dtype=int)
    side = _side(words)
    rest = words.removeprefix(side).strip()
    if rest in PARTS:
        return _on_side(regions, side, PARTS[rest])
    if rest in PRODUCTS:
        return _on_side(regions, side, PRODUCTS[rest].reach)
    try:
        return patches_named(regions, words)
    except ValueError:
        meant = [p.region.removeprefix("*").strip() for p in PLACEMENTS if p.name == rest]
        known = any(rest and set(rest.split()) <= set(stem.split()) for stem in ALL)
        if not (meant or known):
            parts = ", ".join([*SIDES, MIDDLE, *PARTS])
            raise ValueError(
                f"no patch is called {wish!r}: write a part of the body ({parts}), a product "
                f"({', '.join(PRODUCTS)}), or words of a region's name, such as 'left wrist' or 'thigh front'"
            ) from None
        return _on_side(regions, side, meant)


def _on_side(regions: Sequence[str], side: str, stems: Sequence[str]) -> np.ndarray:
    wanted = {f"{s} {stem}".strip() for stem in stems for s in ((side,) if side else ("", *SIDES))}
    return np.array([patch for patch, region in enumerate(regions) if region in wanted], dtype=int)


def _side(words: str) -> str:
    first = words.split(" ", 1)[0]
    return first if first in SIDES else ""


def patches_named(regions: Sequence[str], words: str) -> np.ndarray:
    """Patches whose region's name holds all the words: "left wrist" finds "left wrist dorsal".

    Parameters
    ----------
    regions : sequence of str, length N
        Region of each patch, as in `PatchSet.regions`.
    words : str

    Returns
    -------
    ndarray of int

    Raises
    ------
    ValueError
        If no region's name holds them all.
    """
    wanted = set(words.lower().split())
    found = [patch for patch, region in enumerate(regions) if wanted <= set(region.lower().split())]
    if not found or not wanted:
        known = ", ".join(sorted(set(regions)))
        raise ValueError(f"no patch lies in a region named {words!r}; the regions are: {known}")
    return np.array(found)
