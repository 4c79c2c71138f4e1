# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches by name: the usual and unusual placements of wearables.

A name is resolved to the patch that holds the spot, on any body. The eight common placements are
our reading of what the field uses (watch, armband, chest strap, belt clip, trouser pocket, ankle
band, shoe, earbud); the three unusual ones are those the paper found strong though seldom used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from ..body.body import Body
from ..body.landmarks import SENSOR_SITES
from ..body.regions import regions_of
from ..wording import plain_words
from .patches import PatchSet
from .products import PRODUCTS


@dataclass(frozen=True)
class Placement:
    """A place to wear a sensor.

    Parameters
    ----------
    name : str
        What it is called, e.g. "wrist".
    region : str
        Region at whose centre it lies; "*" stands for left or right.
    common : bool
        Whether wearables are usually worn there.
    """

    name: str
    region: str
    common: bool

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

DEFAULT_SIDE = "left"
"""Side meant when a sided placement is named without one: where most people wear a watch."""


def resolve(name: str, body: Body, patches: PatchSet) -> int:
    """The patch that a name means.

    Parameters
    ----------
    name : str
        A placement ("wrist", "right ankle"; the left one by default), a product ("watch", "shoe"), a
        published sensor site ("TransPose head"), a patch's own name, or words that name a region
        ("left wrist").
    body : Body
    patches : PatchSet
        Of the same body.

    Returns
    -------
    int
        For a site, the patch whose cell holds it; for a region, the patch in it that lies nearest
        to its middle, or, where no patch's centre lies in it, the one whose cell holds the middle.

    Raises
    ------
    ValueError
        If nothing is called that; the message names what comes closest.
    """
    if not isinstance(name, str):
        raise ValueError(f"a placement is a name, such as 'left wrist', not {name!r}")
    wanted = plain_words(name)
    own = {patch.lower(): index for index, patch in enumerate(patches.names)}
    sites = {site.name.lower(): site for site in SENSOR_SITES}
    region_of = _region_by_name()
    if wanted in own:
        return own[wanted]
    if wanted in sites:
        return int(patches.labels[sites[wanted].vertex(body)])
    try:
        return _patch_of_region(body, patches, region_of.get(wanted, wanted))
    except ValueError:
        close = get_close_matches(wanted, [*region_of, *sites, *regions_of(body)[1]], n=4, cutoff=0.5)
        hint = f"; did you mean {', '.join(close)}?" if close else ""
        raise ValueError(f'no placement, sensor site or region is called "{wanted}"{hint}') from None


def _region_by_name() -> dict[str, str]:
    """Region of every placement and product by its name, alone and with its side."""
    meant = {placement.name: placement.region for placement in PLACEMENTS}
    meant |= {name: product.region for name, product in PRODUCTS.items()}
    region_of = {name: region.replace("*", DEFAULT_SIDE) for name, region in meant.items()}
    for side in SIDES:
        region_of |= {
            f"{side} {name}": region.replace("*", side) for name, region in meant.items() if "*" in region
        }
    return region_of


def _patch_of_region(body: Body, patches: PatchSet, words: str) -> int:
    centre = region_centre(body, words)
    inside = np.flatnonzero([region in _regions(body, words) for region in patches.regions])
    if len(inside) == 0:
        return int(patches.labels[centre])
    offset = body.vertices[patches.vertices[inside]] - body.vertices[centre]
    return int(inside[np.argmin(np.linalg.norm(offset, axis=1))])


def _regions(body: Body, words: str) -> list[str]:
    """Names of the regions that words mean: the one called so, or all that hold them."""
    names = regions_of(body)[1]
    return [words] if words in names else [names[number] for number in patches_named(names, words)]


def placement_patches(body: Body, patches: PatchSet, side: str = DEFAULT_SIDE) -> dict[str, int]:
    """Patch of each of the 11 placements on one side of the body, by placement name."""
    return {placement.name: _patch_of_region(body, patches, placement.on(side)) for placement in PLACEMENTS}


def region_centre(body: Body, words: str) -> int:
    """The vertex in the middle of a region, or of all regions whose names hold the words.

    Raises
    ------
    ValueError
        If no region's name holds them.
    """
    codes, names = regions_of(body)
    members = np.flatnonzero(np.isin(codes, [names.index(name) for name in _regions(body, words)]))
    points = body.vertices[members]
    # the middle of the surface, not of its vertices, which crowd where there is detail
    area = _vertex_areas(body)[members]
    middle = np.average(points, axis=0, weights=area)
    return int(members[np.argmin(np.linalg.norm(points - middle, axis=1))])


def _vertex_areas(body: Body) -> np.ndarray:
    """A third of the area of each vertex's faces, shape (V,)."""
    corners = body.vertices[body.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.bincount(body.faces.ravel(), np.repeat(areas / 6, 3), minlength=len(body.vertices))


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
