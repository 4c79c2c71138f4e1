# SPDX-License-Identifier: GPL-3.0-or-later
"""Places on a body in people's words: placements, products, parts, sides and regions, and patches there.

The eight common placements are our reading of what the field uses (watch, armband, chest strap, belt clip,
trouser pocket, ankle band, shoe, earbud); the three unusual ones are those the paper found strong though
seldom used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..body.body import template
from ..wording import plain_words


@dataclass(frozen=True)
class Placement:
    """A place to wear a sensor."""

    name: str  # what it is called: "wrist"
    region: str  # at whose centre it lies; "*" is for left or right
    common: bool  # whether wearables are usually worn there

    @property
    def sided(self) -> bool:
        """Whether it exists on the left and on the right."""
        return "*" in self.region

    def on(self, side: str) -> str:
        """Name of the region on one side."""
        return self.region.replace("*", side)


PLACEMENTS: tuple[Placement, ...] = (
    Placement("wrist", "* wrist dorsal", common=True),
    Placement("upper arm", "* upper arm lateral", common=True),
    Placement("chest", "sternum", common=True),
    Placement("waist", "* hip", common=True),
    Placement("pocket", "* front pocket", common=True),
    Placement("ankle", "* ankle lateral", common=True),
    Placement("foot", "* instep", common=True),
    Placement("ear", "* ear", common=True),
    Placement("posterior scapula", "* posterior scapula", common=False),
    Placement("lower spine", "lower spine", common=False),
    Placement("lateral oblique", "* lateral oblique", common=False),
)
"""The 11 placements: 8 common ones and 3 unusual ones."""


class Product(NamedTuple):
    """A wearable product."""

    region: str  # where its sensor usually sits; "*" is for left or right
    # regions that it touches, without their side: what wishes such as "only belt" mean
    reach: tuple[str, ...]


WRIST = ("wrist dorsal", "wrist thumb side", "wrist little finger side", "wrist volar")
FINGERS = ("index finger", "middle finger", "ring finger", "little finger")
RIBS = ("sternum", "chest", "front ribs", "side ribs", "middle back", "middle spine")

PRODUCTS: dict[str, Product] = {
    "watch": Product("* wrist dorsal", WRIST),
    "ring": Product("* ring finger", FINGERS),
    "earbud": Product("* ear", ("ear",)),
    "glasses": Product("* temple", ("temple", "behind ear", "nose")),
    "headband": Product("forehead", ("forehead", "temple", "side of head", "back of head")),
    "chest strap": Product("sternum", RIBS),
    "belt": Product("* hip", ("hip", "front hip", "lower abdomen", "lower back", "lower spine")),
    "phone in pocket": Product("* front pocket", ("front pocket",)),
    "knee brace": Product("* knee lateral", ("knee lateral", "knee front", "knee medial", "knee back")),
    "shoe": Product("* instep", ("instep", "toes", "heel", "sole", "foot lateral", "foot medial")),
}
"""Our reading of where such products are worn."""


_REGIONS: dict[str, list[str]] = template("regions.json")["parts"]

PARTS = {
    "head": _REGIONS["head"],
    "neck": _REGIONS["neck"],
    "torso": [*_REGIONS["back"], *_REGIONS["chest"], *_REGIONS["front and sides"]],
    "back": _REGIONS["back"],
    "chest": _REGIONS["chest"],
    "arm": [*_REGIONS["arm"], *_REGIONS["hand"]],
    "hand": _REGIONS["hand"],
    "leg": [*_REGIONS["leg"], *_REGIONS["foot"]],
    "foot": _REGIONS["foot"],
}
"""Regions of each part, without their side. An arm includes its hand and a leg its foot."""

ALL = [region for regions in _REGIONS.values() for region in regions]
"""Every region, without its side."""

SIDES = ("left", "right")
MIDDLE = "middle"
"""Where the body has but one: sternum, spine, navel, nose."""


def find_patches(regions: Sequence[str], names: Sequence[str], wish: str) -> np.ndarray:
    """Patches that a person's words mean, from the region and the name of each patch of a `PatchSet`.

    The wish is a side ("left", "right", "middle": on neither), a part of the body with or without its side
    ("head", "left arm"), a product ("belt", "right shoe"), a patch's own name, words of a region's name
    ("left wrist", "pocket"), or one of the 11 placements ("waist"). Empty where the words are understood but
    no patch lies there.

    Raises ValueError if nothing on a body is called that.
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


AROUND = ("shoulder", "upper arm", "elbow", "forearm", "wrist", "thigh", "knee", "lower leg", "ankle")
"""Parts that have a front and a back, or the like."""


def great_part(region: str) -> str:
    """Head, neck, torso, or the arm or leg with its side."""
    side, _, stem = region.partition(" ")
    for limb in ("arm", "leg"):
        if side in SIDES and stem in PARTS[limb]:
            return f"{side} {limb}"
    whole = segment(region)
    return whole if whole in ("head", "neck") else "torso"


def segment(region: str) -> str:
    """The part of the body that a region belongs to, with its side; regions of the torso stay as they are."""
    side = _side(region)
    stem = region.removeprefix(side).strip()
    for part in ("head", "neck"):
        if stem in PARTS[part]:
            return part
    if stem in PARTS["hand"]:
        stem = "hand"
    elif stem in PARTS["foot"]:
        stem = "foot"
    elif stem in ("calf", "shin"):
        stem = "lower leg"
    elif stem in (*PARTS["arm"], *PARTS["leg"]):
        stem = next(part for part in AROUND if stem.startswith(part))
    return f"{side} {stem}".strip()


def patches_named(regions: Sequence[str], words: str) -> np.ndarray:
    """Patches whose region's name holds all the words: "left wrist" finds "left wrist dorsal".

    Raises ValueError if no region's name holds them all.
    """
    wanted = set(words.lower().split())
    found = [patch for patch, region in enumerate(regions) if wanted <= set(region.lower().split())]
    if not found or not wanted:
        known = ", ".join(sorted(set(regions)))
        raise ValueError(f"no patch lies in a region named {words!r}; the regions are: {known}")
    return np.array(found)
