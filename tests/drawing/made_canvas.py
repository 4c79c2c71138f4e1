# SPDX-License-Identifier: GPL-3.0-or-later
"""A canvas that notes what is drawn on it, by its extents and its words."""


class NotingCanvas:
    """Letters are half as wide as high; `drawn` has left, bottom, right and top of each thing."""

    def __init__(self):
        self.drawn, self.written = [], []

    def rectangle(self, x, y, width, height, _colour):
        self.drawn.append((x, y, x + width, y + height))

    bar_of_colours = rectangle

    def polyline(self, points, _colour, _width):
        self.drawn.append((*points.min(axis=0), *points.max(axis=0)))

    def width_of(self, words, size):
        return 0.5 * size * len(words)

    def text(self, x, y, words, size, _colour, align="LEFT"):
        width = self.width_of(words, size)
        x -= {"LEFT": 0, "RIGHT": width}[align]
        self.drawn.append((x, y, x + width, y + 0.8 * size))
        self.written.append(words)
        return width
