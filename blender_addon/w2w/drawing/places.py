# SPDX-License-Identifier: GPL-3.0-or-later
"""Where cards and a legend stand over a picture of a body: at its edges, over nothing that is to be seen."""

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np

SCALES, SMALL, LEGIBLE = (1.0, 0.9, 0.8, 0.7, 0.6), (0.5, 0.4), 0.6
"""Shares of its size at which a thing is tried, those at last, and the smallest legible scale."""

HEIGHTS = 7
"""Heights at which it is tried at each edge."""

GAP = 12
"""Pixels from the edge, at a scale of 1."""


Forms: TypeAlias = Sequence[Callable[[float], tuple[float, float]]]
"""Width and height of a thing in each of its forms, the best first, pixels, at a scale."""


class FreeArea(NamedTuple):
    """The part of a region that no panel covers."""

    left: float
    right: float
    bottom: float
    top: float


class Box(NamedTuple):
    """A rectangle of a region, pixels."""

    left: float
    bottom: float
    right: float
    top: float

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies in it."""
        return self.left <= x <= self.right and self.bottom <= y <= self.top


class Place(NamedTuple):
    """Lower left corner of a thing in a region, pixels, its scale, and the number of its form."""

    x: float
    y: float
    scale: float
    form: int = 0
    covers: float = 0.0

    def box(self, forms: Forms) -> Box:
        """The rectangle that a thing of these forms fills there."""
        width, height = forms[self.form](self.scale)
        return Box(self.x, self.y, self.x + width, self.y + height)


def place_all(
    things: Sequence[Forms], free: FreeArea, clear: np.ndarray, taken: Sequence[Box], scale: float,
    lefts: Callable[[float, float], Sequence[float]],
) -> list[Place]:  # fmt: skip
    """Where things stand, one after the other; where one would cover something, all in their last form.

    Parameters
    ----------
    things : sequence of Forms
    free : FreeArea
    clear : ndarray, shape (K, 2)
        Points of the region to keep clear.
    taken : sequence of Box
        Rectangles to keep clear.
    scale : float
        The largest scale.
    lefts : callable
        Left edges to try for a width and a gap to the view's edge, the best first.
    """
    shares = [share for share in (*SCALES, *SMALL) if share * max(scale, 1.0) >= LEGIBLE]
    usual = sorted(product((0, 1), shares), key=lambda way: way[1] in SMALL)
    tried: list[list[Place]] = []
    for ways in (usual, *([(-1, share)] for share in shares)):
        stands, boxes = [], [*taken]
        for forms in things:
            stands.append(_place(forms, ways, free, clear, boxes, scale, lefts))
            boxes.append(stands[-1].box(forms))
        tried.append(stands)
        if not any(stand.covers for stand in stands):
            break
    return min(tried, key=lambda stands: sum(stand.covers for stand in stands))


def _place(
    forms: Forms, ways: Sequence[tuple[int, float]], free: FreeArea, clear: np.ndarray, taken: Sequence[Box],
    scale: float, lefts: Callable[[float, float], Sequence[float]],
) -> Place:  # fmt: skip
    """The first place that covers nothing, by forms and shares of the scale; else the best there is."""
    tried: list[Place] = []
    for form, share in ways:
        number, tried_at = form % len(forms), share * scale
        width, height = forms[number](tried_at)
        gap = GAP * tried_at
        top = max(free.top - gap - height, free.bottom + gap)
        on_others = [each.top + gap / 4 for each in taken if each.top + gap / 4 < top]
        heights = [*np.linspace(free.bottom + gap, top, HEIGHTS).tolist(), *on_others]
        for x, y in product(lefts(width, gap), heights):
            stand = Place(x, y, tried_at, number)
            tried.append(stand._replace(covers=_covers(stand.box(forms), free, clear, taken)))
            if not tried[-1].covers:
                return tried[-1]
    return min(tried, key=lambda each: each.covers)


def _covers(box: Box, free: FreeArea, clear: np.ndarray, taken: Sequence[Box]) -> float:
    """How many points a rectangle covers; one that reaches into another or out of sight counts all."""
    low, high = (box.left, box.bottom), (box.right, box.top)
    inside = ((clear > low) & (clear < high)).all(axis=1)
    meets = sum((np.less(low, each[2:]) & np.less(each[:2], high)).all() for each in taken)
    out = box.left < free.left or box.right > free.right or box.top > free.top
    return float(inside.sum()) + (int(meets) + 3 * out) * (len(clear) + 1)
