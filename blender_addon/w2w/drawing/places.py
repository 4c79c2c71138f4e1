# SPDX-License-Identifier: GPL-3.0-or-later
"""Where cards and a legend stand over a picture of a body: at its edges, over nothing that is to be seen."""

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

SCALES, SMALL, LEGIBLE = (1.0, 0.9, 0.8, 0.7, 0.6), (0.5, 0.4), 0.6
"""Shares of its size at which a thing is tried, those at last, and the smallest legible scale."""

HEIGHTS = 7
"""Heights at which it is tried at each edge."""

GAP = 12
"""Pixels from the edge, at a scale of 1."""


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


def place(
    forms: Sequence[Callable[[float], tuple[float, float]]], free: FreeArea, clear: np.ndarray,
    taken: Sequence[Box], scale: float, lefts: Callable[[float, float], Sequence[float]],
) -> Place:  # fmt: skip
    """The first place that covers nothing, the largest there is; else the one that covers least.

    Parameters
    ----------
    forms : sequence of callable
        Width and height of the thing in each of its forms, the best first, pixels, at a scale.
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
    tried: list[Place] = []
    ways = [*product(range(len(forms)), SCALES), *product(range(len(forms)), SMALL)]
    for form, share in [way for way in ways if way[1] * max(scale, 1.0) >= LEGIBLE]:
        tried_at = share * scale
        width, height = forms[form](tried_at)
        gap = GAP * tried_at
        top = max(free.top - gap - height, free.bottom + gap)
        for x in lefts(width, gap):
            for y in np.linspace(free.bottom + gap, top, HEIGHTS).tolist():
                covers = _covers(Box(x, y, x + width, y + height), free, clear, taken)
                tried.append(Place(x, y, tried_at, form, covers))
                if not covers:
                    return tried[-1]
    return min(tried, key=lambda each: each.covers)


def _covers(box: Box, free: FreeArea, clear: np.ndarray, taken: Sequence[Box]) -> float:
    """How many points a rectangle covers; one that reaches into another or out of sight counts all."""
    low, high = (box.left, box.bottom), (box.right, box.top)
    inside = ((clear > low) & (clear < high)).all(axis=1)
    meets = sum((np.less(low, each[2:]) & np.less(each[:2], high)).all() for each in taken)
    out = box.left < free.left or box.right > free.right or box.top > free.top
    return float(inside.sum()) + (int(meets) + 3 * out) * (len(clear) + 1)
