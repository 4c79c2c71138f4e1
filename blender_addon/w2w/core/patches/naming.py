# SPDX-License-Identifier: GPL-3.0-or-later
"""Places by name: where on a body they are, and the patch of a map that represents them.

A name means a vertex of the skin, on any body: a sensor that is simulated for it sits right there. In a
map it means the nearest patch, if that is near enough.
"""

import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from difflib import get_close_matches
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from ..body.body import Body, face_normals
from ..body.landmarks import PLACES, SENSOR_SITES
from ..body.regions import regions_of
from ..wording import plain_words
from .body_parts import PLACEMENTS, PRODUCT_NAMED, SIDES, Place, patches_named
from .patches import PatchSet
from .spots import Spot, vertex_at

DEFAULT_SIDE = "left"
"""Side meant when a sided placement is named without one: where most people wear a watch."""

NEAR_M, FAR_M = 0.05, 0.1
"""How far from a place its patch may lie: without a note, and at most."""

OUTER = ("lateral", "dorsal")
"""The side of a limb that is meant if none is given: most straps have their sensor there."""


class Nearest(NamedTuple):
    """The patch that represents a place in a map, and the distance of its centre from the place, metres."""

    patch: int
    away_m: float


def place(name: str, body: Body) -> int:
    """The vertex of the skin that a name means, independent of patches.

    A name is a placement ("wrist", "right ankle"; the left one by default), a product ("watch", "shoe"), a
    published sensor site ("TransPose head"), words that name a region ("left wrist"), or a spot by a tape
    ("left forearm 85% 50%", see `Spot`). A region's vertex is its landmark (`landmarks.PLACES`) or the one in
    its middle.

    Raises ValueError if nothing is called that; the message names what comes closest.
    """
    wanted = _words_of(name)
    if wanted.endswith("%"):
        return vertex_at(body, Spot.parse(wanted))
    sites = {site.name.lower(): site for site in SENSOR_SITES}
    region_of = _region_by_name()
    if wanted in sites:
        return sites[wanted].vertex(body)
    try:
        return _vertex(body, region_of.get(wanted, wanted))
    except ValueError:
        close = get_close_matches(wanted, [*region_of, *sites, *regions_of(body)[1]], n=4, cutoff=0.5)
        hint = f"; did you mean {', '.join(close)}?" if close else ""
        raise ValueError(f'no placement, sensor site or region is called "{wanted}"{hint}') from None


def resolve(
    name: str,
    body: Body | None,
    patches: PatchSet,
    say: Callable[[str], object] = warnings.warn,
    silent_m: float = NEAR_M,
) -> int:
    """The patch of a map that a name means: a patch's own name, or on a body a place as `place` takes it.

    For a place it is the nearest patch over the skin; `say` is given a sentence with its distance if that
    is beyond `silent_m`.

    Raises ValueError if nothing is called that, or no patch lies within 10 cm of the place.
    """
    words, own = _words_of(name), [patch.lower() for patch in patches.names]
    if words in own:
        return own.index(words)
    if body is None:
        raise ValueError(f"no sensor was worn at {name!r}; there are {', '.join(patches.names)}")
    return nearest(name, name, body, patches, say, silent_m).patch


def nearest(
    called: str,
    where: str,
    body: Body,
    patches: PatchSet,
    say: Callable[[str], object],
    silent_m: float = NEAR_M,
) -> Nearest:
    """The patch nearest to the place `where`, which a sentence for `say` calls `called`; like `resolve`."""
    vertex = place(where, body)
    patch, away = found = nearest_patch(vertex, body, patches)
    sentence = f"the nearest patch to '{called}' is {100 * away:.1f} cm away ({patches.names[patch]})"
    if away > FAR_M:
        raise ValueError(
            f"{sentence}, too far to stand for it: sample more than {len(patches)} patches, or add a "
            f"placement of your own at vertex {vertex}"
        )
    if away > silent_m:
        say(f"{sentence}: take it as a rough guide, or use more patches" if away > NEAR_M else sentence)
    return found


def nearest_patch(vertex: int, body: Body, patches: PatchSet) -> Nearest:
    """The patch nearest to a vertex over the skin."""
    patch = int(patches.labels[vertex])
    away = np.linalg.norm(body.vertices[patches.vertices[patch]] - body.vertices[vertex])
    return Nearest(patch, float(away))


@lru_cache(maxsize=4)
def places_on(body: Body) -> dict[str, int]:
    """Vertex of each name that `place` knows on a body, but for spots: placements, products, sites, regions.

    Words of a region are names, too. The last few bodies' are kept.
    """
    regions = regions_of(body)[1]
    stems = {" ".join(some) for region in regions for some in _runs(region.split())}
    names = sorted({*_region_by_name(), *(site.name.lower() for site in SENSOR_SITES), *stems})
    places = {}
    for name in names:
        with suppress(ValueError):  # a body may lack a region
            places[name] = place(name, body)
    return places


def _runs(words: list[str]) -> Iterator[list[str]]:
    """All runs of neighbouring words."""
    for first in range(len(words)):
        yield from (words[first:last] for last in range(first + 1, len(words) + 1))


def _words_of(name: str) -> str:
    if not isinstance(name, str):
        raise ValueError(f"a placement is a name, such as 'left wrist', not {name!r}")
    return plain_words(name)


@cache
def _region_by_name() -> dict[str, str]:
    """Region of every placement and product by its name, alone and with its side."""
    meant: dict[str, Place] = {**{placement.name: placement for placement in PLACEMENTS}, **PRODUCT_NAMED}
    region_of = {name: place.on(DEFAULT_SIDE) for name, place in meant.items()}
    for side in SIDES:
        region_of |= {f"{side} {name}": place.on(side) for name, place in meant.items() if place.sided}
    return region_of


@lru_cache(maxsize=1024)
def _vertex(body: Body, words: str) -> int:
    """The vertex of a region: on the right the mirror image of that on the left, if the body knows it."""
    if body.mirror is not None and words.startswith("right "):
        return int(body.mirror[_vertex(body, words.replace("right", "left", 1))])
    landmark = next((site for site in PLACES if site.name == words), None)
    return landmark.vertex(body) if landmark else _middle(body, words)


def _middle(body: Body, words: str) -> int:
    """The vertex in the middle of a region, or of all whose names hold the words; round a limb, outside."""
    codes, names = regions_of(body)
    regions = [words] if words in names else [names[number] for number in patches_named(names, words)]
    outer = [region for region in regions if region.endswith(OUTER)]
    members = np.flatnonzero(np.isin(codes, [names.index(region) for region in outer or regions]))
    points = body.vertices[members]
    # the middle of the surface, not of its vertices, which crowd where there is detail
    middle = np.average(points, axis=0, weights=_vertex_areas(body)[members])
    return int(members[np.argmin(np.linalg.norm(points - middle, axis=1))])


@lru_cache(maxsize=8)
def _vertex_areas(body: Body) -> np.ndarray:
    """A third of the area of each vertex's faces, shape (V,)."""
    areas = np.linalg.norm(face_normals(body.vertices[body.faces]), axis=1)
    return np.bincount(body.faces.ravel(), np.repeat(areas / 6, 3), minlength=len(body.vertices))
