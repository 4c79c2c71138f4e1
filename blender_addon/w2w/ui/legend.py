# SPDX-License-Identifier: GPL-3.0-or-later
"""What the colours of the body stand for: a heatmap, or the difference of two."""

from __future__ import annotations

from typing import NamedTuple

import bpy

from ..core.colours import DIFFERENCE_MAP, difference_range
from ..core.ranking.utility import UtilityMap
from .scores import EXPECTED, colour_range, minus_index, range_note, shown_scores, view_index
from .second_map import name_of


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


def map_name(study: bpy.types.PropertyGroup, index: int) -> str:
    """Name of a heatmap by its number."""
    return "Mean of activities" if index == 0 else study.activities[index - 1].name
