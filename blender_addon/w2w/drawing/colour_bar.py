# SPDX-License-Identifier: GPL-3.0-or-later
"""The legend of a map's colours: upright at its side, or flat where that is narrow."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..core.colours import Scale, colour_table
from .canvas import Canvas, clipped
from .card import BACKGROUND, GREY, MARGIN, PALE
from .places import Place

BAR_WIDTH, BAR_HEIGHT, BAR_TICKS = 16, 190, 5
"""Size of the upright bar, pixels at a scale of 1, and its numbers."""

TITLE_ROOM, NAME_ROOM = 96, 200
"""Least room for the title and most for a name, pixels at a scale of 1."""

FLAT_LINE, FLAT_NUMBER = 15, 32
"""Height of a line of the flat legend, and width of the number at each end of its bar, at a scale of 1."""


@dataclass(frozen=True)
class Legend(Scale):
    """The colours of the heatmap that is shown, with what stands next to them."""

    name: str = ""
    number: str = ".2f"
    """Format of scores."""
    beside: str = ""
    """Name of the second map."""


def sizes(shown: Legend, canvas: Canvas) -> list[Callable[[float], tuple[float, float]]]:
    """Width and height, pixels, of a legend that stands and of one that lies, at a scale."""
    return [partial(_size, canvas, shown, lies) for lies in (False, True)]


def draw_colour_bar(shown: Legend, stand: Place, canvas: Canvas) -> None:
    """Draw a legend: title, colours and numbers, or in words that places are alike."""
    size = sizes(shown, canvas)[stand.form](stand.scale)
    canvas.rectangle(stand.x, stand.y, *size, BACKGROUND)
    (_draw_flat if stand.form else _draw_upright)(canvas, shown, stand, *size)


def _names(canvas: Canvas, shown: Legend, scale: float) -> list[str]:
    """The names of the maps in a legend, the second one's first."""
    return [
        clipped(canvas, name, NAME_ROOM * scale, 12 * scale) for name in (shown.beside, shown.name) if name
    ]


def _size(canvas: Canvas, shown: Legend, lies: bool, scale: float) -> tuple[float, float]:
    names = [canvas.width_of(name, 12 * scale) for name in _names(canvas, shown, scale)]
    beside = names[-1] + 6 * scale + canvas.width_of(shown.title, 10 * scale)
    wide = max(*names, canvas.width_of(shown.note, 10 * scale), beside if lies else TITLE_ROOM * scale)
    lines, has_bar = len(names) + bool(shown.note), not shown.is_alike
    tall = FLAT_LINE * (lines + has_bar) + 8 if lies else 46 + 16 * lines + has_bar * BAR_HEIGHT
    return wide + 2 * MARGIN * scale, tall * scale


def _draw_upright(canvas: Canvas, shown: Legend, stand: Place, _wide: float, _tall: float) -> None:
    scale, low, high = stand.scale, shown.low, shown.high
    foot, height = (16 * scale if shown.note else 0.0), 0.0 if shown.is_alike else BAR_HEIGHT * scale
    left, bottom, width = stand.x + MARGIN * scale, stand.y + 16 * scale + foot, BAR_WIDTH * scale
    if not shown.is_alike:
        canvas.bar_of_colours(left, bottom, width, height, colour_table(shown.colour_map, 64))
    for tick in () if shown.is_alike else np.linspace(0, 1, BAR_TICKS):
        y = bottom + tick * height
        canvas.rectangle(left + width, round(y), 4 * scale, max(1, scale), GREY)
        number = format(low + tick * (high - low), shown.number)
        canvas.text(left + width + 8 * scale, y - 4 * scale, number, 11 * scale, PALE)
    for line, name in enumerate(_names(canvas, shown, scale)):
        canvas.text(left, bottom + height + (28 + 16 * line) * scale, name, 12 * scale, PALE)
    canvas.text(left, bottom + height + 14 * scale, shown.title, 10 * scale, GREY)
    canvas.text(left, bottom - 20 * scale, shown.note, 10 * scale, GREY)


def _draw_flat(canvas: Canvas, shown: Legend, stand: Place, wide: float, tall: float) -> None:
    scale, y, end = stand.scale, stand.y + tall - 2 * stand.scale, 0.0
    left, right, room = stand.x + MARGIN * scale, stand.x + wide - MARGIN * scale, FLAT_NUMBER * scale
    for name in _names(canvas, shown, scale):
        y -= FLAT_LINE * scale
        end = left + canvas.text(left, y, name, 12 * scale, PALE) + 6 * scale
    canvas.text(end, y, shown.title, 10 * scale, GREY)
    y -= FLAT_LINE * scale
    if not shown.is_alike:
        colours = colour_table(shown.colour_map, 64)
        canvas.text(left, y, format(shown.low, shown.number), 11 * scale, PALE)
        canvas.bar_of_colours(left + room, y - scale, right - left - 2 * room, 9 * scale, colours)
        canvas.text(right, y, format(shown.high, shown.number), 11 * scale, PALE, "RIGHT")
        y -= FLAT_LINE * scale
    canvas.text(left, y, shown.note, 10 * scale, GREY)
