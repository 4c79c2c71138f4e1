# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores as colours: one perceptual colour map for all pictures; without scores, a plain mannequin."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Self

import numpy as np

from .body.body import TEMPLATES, Body, midpoint
from .files import load_arrays
from .patches.body_parts import in_part, sleeves, waist
from .patches.patches import PatchSet

COLOUR_MAP = "viridis"
"""Rises evenly in lightness and stays in order for colour-blind eyes (Smith & van der Walt 2015,
"A better default colormap for Matplotlib"), and stands out from a white page and a dark viewport."""

NEUTRAL_GREY = (0.76, 0.76, 0.76)
"""sRGB colour of a place without a score."""

DIFFERENCE_MAP = "vik"
"""Diverging map for differences: blue below zero, brown above, pale at zero; safe for colour-blind
eyes (Crameri 2018, doi:10.5281/zenodo.1243862)."""

COLOUR_MAPS = (COLOUR_MAP, "cividis", "magma", "batlow", DIFFERENCE_MAP)
"""Maps in `colour_maps.npz`, which `tools/make_colour_maps.py` takes from the `cmap` package."""

LEAST_SPAN = 0.1
"""Least F1 that the colours of a map span: scores that hardly differ shall not look far apart."""

ROUNDING = 1e-6

SKIN, SHIRT, SHORTS = (0.84, 0.80, 0.765), (0.62, 0.68, 0.74), (0.30, 0.36, 0.43)
"""sRGB colours of a mannequin."""

LENGTH = 0.65
"""How far down its shorts reach, as a share of the thigh."""

SOFT = 0.03
"""Width of a hem, metres: about an edge of the mesh, or it would show the triangles."""


def score_colours(scores: np.ndarray, low: float, high: float, colour_map: str = COLOUR_MAP) -> np.ndarray:
    """Colours (..., 3) of scores (...), sRGB from 0 to 1; NaN becomes `NEUTRAL_GREY`.

    `low` and `high` are the scores at the two ends of the colour map; scores outside get the colour of the
    nearer end. `colour_map` is one of COLOUR_MAPS.

    Raises ValueError if there is no such colour map, if `low` is above `high` or one of them is not finite.
    """
    scores = np.asarray(scores, dtype=np.float64)
    if not (np.isfinite(low) and np.isfinite(high) and low <= high):
        raise ValueError(
            f"the colour range must run from a lower to a higher score, not from {low} to {high}"
        )
    # equal ends leave no range to spread over: everything there is takes the middle colour
    shares = (scores - low) / (high - low) if high > low else np.full(scores.shape, 0.5)
    table = colour_table(colour_map)
    colours = table[np.rint(np.clip(np.nan_to_num(shares), 0, 1) * (len(table) - 1)).astype(np.intp)]
    colours[np.isnan(scores)] = NEUTRAL_GREY
    return colours


@dataclass(frozen=True)
class Scale:
    """Meaning of a map's colours: scores from `low` to `high`, called `title`; a legend adds the `note`."""

    low: float
    high: float
    title: str = "F1"
    note: str = ""
    colour_map: str = COLOUR_MAP
    is_alike: bool = False
    """Whether places do alike: all of them are shown as places without a score."""

    @classmethod
    def of(
        cls, scores: np.ndarray, span: float = LEAST_SPAN, title: str = "F1", colour_map: str = COLOUR_MAP
    ) -> Self:
        """The scale of the scores' own range, at least `span` wide; if it is wider, the note says so."""
        low, high = score_range(scores, span)
        return cls(low, high, title, span_note(scores, low, high), colour_map)

    @classmethod
    def of_places(cls, scores: np.ndarray, title: str, colour_map: str, differ: bool) -> Self:
        """Like `of`, but of no colours where places are alike, and the note says so.

        They are alike within `LEAST_SPAN`, or within half of it where the answer is that they `differ`.
        """
        scale, low, high = cls.of(scores, LEAST_SPAN, title, colour_map), scores.min(), scores.max()
        if high - low >= (LEAST_SPAN / 2 if differ else LEAST_SPAN):
            return scale
        return replace(scale, note=f"Places are alike: {low:.2f} to {high:.2f}", is_alike=True)

    @classmethod
    def of_difference(cls, scores: np.ndarray) -> Self:
        """The scale of differences of scores, as far from none on both sides."""
        reach = max(float(np.nanmax(np.abs(scores), initial=0.0)), LEAST_SPAN / 2)
        return cls(-reach, reach, "Difference of F1", colour_map=DIFFERENCE_MAP)

    def colours(self, patches: PatchSet, scores: np.ndarray) -> np.ndarray:
        """Colours (V, 3) of a body's vertices from scores (N,) of its patches, spread smoothly between them.

        A patch without a score (NaN) has grey ground.
        """
        shown = np.full_like(scores, np.nan) if self.is_alike else scores
        return score_colours(patches.to_vertices(shown), self.low, self.high, self.colour_map)


def score_range(scores: np.ndarray | Sequence[float], span: float = LEAST_SPAN) -> tuple[float, float]:
    """Scores at the two ends of a map's colours: its lowest and highest, or further apart.

    They are at least `span` apart, the scores in the middle as far as F1 allows; 0 and 1 without a
    score.
    """
    low, high = _own_range(scores)
    if high - low >= span:
        return low, high
    end = (low + high - span) / 2
    if low >= 0 and high <= 1:
        end = min(max(end, 0.0), 1.0 - span)
    return end, end + span


def span_note(scores: np.ndarray | Sequence[float], low: float, high: float) -> str:
    """A legend's note on the range of the scores, if the colours span more; else ""."""
    own_low, own_high = _own_range(scores)
    wider = high - low > own_high - own_low + ROUNDING
    return f"scores {own_low:.2f} to {own_high:.2f}" if wider else ""


def _own_range(scores: np.ndarray | Sequence[float]) -> tuple[float, float]:
    finite = np.asarray(scores, dtype=np.float64)
    finite = finite[np.isfinite(finite)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)


def colour_table(colour_map: str = COLOUR_MAP, steps: int = 1024) -> np.ndarray:
    """A colour map from its low to its high end, sRGB, shape (steps, 3)."""
    if colour_map not in COLOUR_MAPS:
        raise ValueError(f"no colour map is called {colour_map!r}; there are {', '.join(COLOUR_MAPS)}")
    table = _tables()[colour_map]
    return table[np.minimum(np.linspace(0, len(table), steps).astype(np.intp), len(table) - 1)]


@cache
def _tables() -> dict[str, np.ndarray]:
    """Each colour map at even steps, shape (256, 3), by its name."""
    return load_arrays(TEMPLATES / "colour_maps.npz", COLOUR_MAPS, "does not hold the colour maps")


def mannequin_colours(body: Body) -> np.ndarray:
    """Colours (V, 3) of a body in a shirt and shorts, which anyone can show."""
    hip, knee = (midpoint(body.joints, name)[2] for name in ("hip", "knee"))
    height = body.vertices[:, 2]
    shirt = np.maximum(in_part(body, "torso"), _inside(sleeves(body)))
    below, above = waist(body) - height, height - (hip + LENGTH * (knee - hip))
    shorts = (in_part(body, "torso") | in_part(body, "leg")) * _inside(np.minimum(below, above))
    colours = np.tile(SKIN, (len(height), 1))
    for share, colour in ((shirt, SHIRT), (shorts, SHORTS)):
        colours += share[:, None] * (colour - colours)
    return colours


def _inside(depth: np.ndarray) -> np.ndarray:
    """How much cloth there is, 0 to 1, at a depth from its hem, metres."""
    return np.clip(0.5 + depth / SOFT, 0, 1)
