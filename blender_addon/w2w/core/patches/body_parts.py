# SPDX-License-Identifier: GPL-3.0-or-later
"""Places on a body in people's words: placements, products, parts, sides and regions, and patches there.

The eight common placements are our reading of what the field uses (watch, armband, chest strap, belt clip,
trouser pocket, ankle band, shoe, earbud); the three unusual ones are those the paper found strong though
seldom used.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np

from ..body.body import JOINT_INDEX, Body, midpoint, template
from ..body.regions import regions_of
from ..wording import plain_words

SIDES = ("left", "right")

SLEEVE, WAIST = 0.7, 0.22
"""A sleeve's end along the upper arm, and the waist from hips to shoulders, as shares."""


@dataclass(frozen=True)
class Place:
    """A place to wear a sensor."""

    name: str  # what it is called: "wrist"
    region: str  # at whose centre it lies; "*" is for left or right

    @property
    def sided(self) -> bool:
        """Whether it exists on the left and on the right."""
        return "*" in self.region

    def on(self, side: str) -> str:
        """Name of the region on one side."""
        return self.region.replace("*", side)


PLACEMENTS: tuple[Place, ...] = (
    Place("wrist", "* wrist dorsal"),
    Place("upper arm", "* upper arm lateral"),
    Place("chest", "sternum"),
    Place("waist", "* hip"),
    Place("pocket", "* front pocket"),
    Place("ankle", "* ankle lateral"),
    Place("foot", "* instep"),
    Place("ear", "* ear"),
    Place("posterior scapula", "* posterior scapula"),
    Place("lower spine", "lower spine"),
    Place("lateral oblique", "* lateral oblique"),
)
"""The 11 placements: 8 common ones, then 3 unusual ones."""


@dataclass(frozen=True)
class Product(Place):
    """A wearable product, as `assets/templates/products.json` describes it."""

    phrase: str  # with its article: "a watch"
    # regions that it touches, without their side: what wishes such as "only belt" mean
    reach: tuple[str, ...]
    wanders: tuple[str, ...]  # regions over which a loose one moves; empty if it sits still

    @property
    def sides(self) -> tuple[str, ...]:
        """The sides it can be worn on; ("",) if it has none."""
        return SIDES if self.sided else ("",)


def _product(
    name: str, region: str, reach: list[str], phrase: str = "", wanders: Sequence[str] = (), **_: Any
) -> Product:
    article = "an" if name[0] in "aeiou" else "a"
    return Product(name, region, phrase or f"{article} {name}", tuple(reach), tuple(wanders))


_TABLE: list[dict[str, Any]] = template("products.json")["products"]

PRODUCTS: dict[str, Product] = {entry["name"]: _product(**entry) for entry in _TABLE}
"""Usual products by their names, the commonest first: our reading of where they are worn."""

PRODUCT_NAMED: dict[str, Product] = {
    word: PRODUCTS[entry["name"]] for entry in _TABLE for word in (entry["name"], *entry["also"])
}
"""Usual products by every word for them: "smartwatch", "pendant", "insole"."""

HABIT = "belt clip"
"""The product that stands for what people wear anyway."""


def product_called(word: str) -> Product:
    """The product of a name or another word for it; ValueError if there is none."""
    product = PRODUCT_NAMED.get(plain_words(word)) if isinstance(word, str) else None
    if product is None:
        raise ValueError(f"no product is called {word!r}: there are {', '.join(PRODUCTS)}")
    return product


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

LIKE = 0.75
"""Least likeness of two words of which one may be meant by the other."""

MIDDLE = "middle"
"""Places that a body has once: sternum, spine, navel, nose."""


def find_patches(regions: Sequence[str], names: Sequence[str], wish: str) -> np.ndarray:
    """Numbers of the patches that a person's words mean, from the region and the name of each patch.

    The wish is a side ("left", "right", "middle": on neither), a part of the body with or without its side
    ("head", "left arm"), a product ("belt", "right shoe"), a patch's own name, words of a region's name
    ("left wrist", "pocket"), or one of the 11 placements ("waist"). Empty if the words are understood but
    no patch lies there.

    Raises ValueError if nothing on a body is called that.
    """
    words = plain_words(wish)
    known = [name.lower() for name in names]
    if words in known:
        return np.array([known.index(words)])
    if words == MIDDLE:
        return np.array([patch for patch, region in enumerate(regions) if not side_of(region)[0]], dtype=int)
    side, rest = side_of(words)
    if rest in PARTS:
        return _on_side(regions, side, PARTS[rest])
    if rest in PRODUCT_NAMED:
        return _on_side(regions, side, PRODUCT_NAMED[rest].reach)
    try:
        return patches_named(regions, words)
    except ValueError:
        meant = [p.region.removeprefix("*").strip() for p in PLACEMENTS if p.name == rest]
        is_stem = any(rest and set(rest.split()) <= set(stem.split()) for stem in ALL)
        if not (meant or is_stem):
            stems = [*PARTS, *PRODUCT_NAMED, *(placement.name for placement in PLACEMENTS)]
            known = [*stems, *(f"{side} {stem}" for side in SIDES for stem in stems), *regions]
            if close := get_close_matches(words, known, n=1, cutoff=LIKE):
                raise ValueError(f"no patch is called {wish!r}; did you mean {close[0]}?") from None
            parts = ", ".join([*SIDES, MIDDLE, *PARTS])
            raise ValueError(
                f"no patch is called {wish!r}: write a part of the body ({parts}), a product "
                f"({', '.join(PRODUCTS)}), or words of a region's name, such as 'left wrist' or 'thigh front'"
            ) from None
        return _on_side(regions, side, meant)


def is_understood(regions: Sequence[str], names: Sequence[str], wishes: str) -> bool:
    """Whether all wishes, separated by commas, mean something on a body; see `find_patches`."""
    try:
        for wish in filter(str.strip, wishes.split(",")):
            find_patches(regions, names, wish)
    except ValueError:
        return False
    return True


def suggestions(regions: Sequence[str], names: Sequence[str], typed: str) -> list[str]:
    """Sides, parts, products, placements and regions whose names contain all typed words."""
    sided = [f"{side} {part}" for part in ("arm", "hand", "leg", "foot") for side in SIDES]
    common = [*PRODUCT_NAMED, *(placement.name for placement in PLACEMENTS)]
    every = [*SIDES, MIDDLE, *PARTS, *sided, *common, *sorted(set(regions)), *names]
    words = typed.lower().split()
    return [name for name in dict.fromkeys(every) if all(word in name for word in words)]


def _on_side(regions: Sequence[str], side: str, stems: Sequence[str]) -> np.ndarray:
    wanted = {f"{s} {stem}".strip() for stem in stems for s in ((side,) if side else ("", *SIDES))}
    return np.array([patch for patch, region in enumerate(regions) if region in wanted], dtype=int)


def side_of(words: str) -> tuple[str, str]:
    """The side that a name begins with, or "", and the rest of it."""
    first, _, rest = words.partition(" ")
    return (first, rest.strip()) if first in SIDES else ("", words)


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
    side, stem = side_of(region)
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
    patches = [patch for patch, region in enumerate(regions) if wanted <= set(region.lower().split())]
    if not patches or not wanted:
        known = ", ".join(sorted(set(regions)))
        raise ValueError(f"no patch lies in a region named {words!r}; the regions are: {known}")
    return np.array(patches)


def in_part(body: Body, part: str) -> np.ndarray:
    """Whether each vertex (V,) lies in a part of the body, either side."""
    codes, names = regions_of(body)
    plain = [name.removeprefix("left ").removeprefix("right ") for name in names]
    return np.isin(codes, [code for code, name in enumerate(plain) if name in PARTS[part]])


def sleeves(body: Body) -> np.ndarray:
    """How far each vertex (V,) of the upper arms is from the end of a sleeve, metres; negative elsewhere."""
    depth = np.full(len(body.vertices), -np.inf)
    for side in SIDES:
        shoulder, elbow = (body.joints[JOINT_INDEX[f"{side}_{name}"]] for name in ("shoulder", "elbow"))
        bone = elbow - shoulder
        along = (body.vertices - shoulder) @ bone / (bone @ bone)
        covered = _named(body, (f"{side} shoulder", f"{side} upper arm"))
        depth[covered] = (SLEEVE - along[covered]) * np.linalg.norm(bone)
    return depth


def waist(body: Body) -> float:
    """Height of a body's waist, metres."""
    hip, shoulder = (midpoint(body.joints, name)[2] for name in ("hip", "shoulder"))
    return hip + WAIST * (shoulder - hip)


def _named(body: Body, beginnings: tuple[str, ...]) -> np.ndarray:
    codes, names = regions_of(body)
    return np.isin(codes, [code for code, name in enumerate(names) if name.startswith(beginnings)])
