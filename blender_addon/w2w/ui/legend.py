# SPDX-License-Identifier: GPL-3.0-or-later
"""What the colours of the body stand for: a heatmap, or the difference of two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import bpy

from ..core.colours import DIFFERENCE_MAP, difference_range
from ..core.ranking.utility import UtilityMap
from .scores import EXPECTED, colour_range, minus_index, range_note, shown_scores, view_index
from .second_map import name_of

BODIES_APART = 2.0
"""Widths of the legend from the middle of one body to that of the next, for it to stand between them."""


class Legend(NamedTuple):
    """What stands beside the colours."""

    name: str
    title: str
    low: float
    high: float
    colour_map: str
    note: str
    number: str
    """How scores are written."""
    beside: str = ""
    """Name of the map beside."""


def legend(study: bpy.types.PropertyGroup, utility: UtilityMap) -> Legend:
    """The legend of the heatmap that is shown."""
    scores, name = shown_scores(study, utility), map_name(study, view_index(study))
    if minus_index(study) >= 0:
        name = f"{name} minus {map_name(study, minus_index(study))}"
        return Legend(name, "Difference of F1", *difference_range(scores), DIFFERENCE_MAP, "", "+.2f")
    low, high = colour_range(study, scores, utility)
    title = "Expected F1" if study.scores == EXPECTED else "F1 on these clips"
    note = range_note(study, scores, utility)
    return Legend(name, title, low, high, study.colour_map, note, ".2f", name_of(study))


def left_of_legend(width: float, left: float, right: float, bodies: Sequence[float]) -> float:
    """Left edge of the legend: midway between two bodies that leave it room, else as far right as can be.

    Parameters
    ----------
    width : float
        Of the legend; all in pixels.
    left, right : float
        Edges of what no panel and no card covers.
    bodies : sequence of float
        Where across the view the middles of two bodies side by side are; empty where one stands alone.
    """
    if len(bodies) == 2 and abs(bodies[1] - bodies[0]) >= BODIES_APART * width:
        between = (sum(bodies) - width) / 2
        if left <= between <= right - width:
            return between
    return right - width


def map_name(study: bpy.types.PropertyGroup, index: int) -> str:
    """Name of a heatmap by its number."""
    return "Mean of activities" if index == 0 else study.activities[index - 1].name
