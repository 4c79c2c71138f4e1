# SPDX-License-Identifier: GPL-3.0-or-later
"""What cards and legends are drawn on: a 3D view in Blender, a list in tests."""

from typing import Protocol

import numpy as np

Colour = tuple[float, float, float, float]


class Canvas(Protocol):
    """Draws in pixels from the lower left corner of a region."""

    def rectangle(self, x: float, y: float, width: float, height: float, colour: Colour) -> None:
        """Fill a rectangle; x and y are its lower left corner."""

    def bar_of_colours(self, x: float, y: float, width: float, height: float, colours: np.ndarray) -> None:
        """Fill a rectangle with colours (K, 3) in sRGB, along its longer side."""

    def polyline(self, points: np.ndarray, colour: Colour, width: float) -> None:
        """Draw a line through points (K, 2); NaN breaks it."""

    def width_of(self, words: str, size: float) -> float:
        """Width of one line of text."""

    def text(self, x: float, y: float, words: str, size: float, colour: Colour, align: str = "LEFT") -> float:
        """Write one line with its baseline at y; returns its width."""


def clipped(canvas: Canvas, words: str, width: float, size: float) -> str:
    """A text cut to at most this width."""
    if canvas.width_of(words, size) <= width:
        return words
    while words and canvas.width_of(words + "…", size) > width:
        words = words[:-1]
    return words.rstrip() + "…"
