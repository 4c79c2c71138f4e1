# SPDX-License-Identifier: GPL-3.0-or-later
"""Rectangles, lines and text on a region, in pixels; only from within a draw handler."""

from __future__ import annotations

from collections.abc import Sequence

import blf
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from .text import FONT

Colour = tuple[float, float, float, float]


def rectangle(x: float, y: float, width: float, height: float, colour: Colour) -> None:
    """Fill a rectangle; x and y are its lower left corner."""
    corners = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": corners}, indices=((0, 1, 2), (0, 2, 3)))
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("color", colour)
    batch.draw(shader)


def bar_of_colours(x: float, y: float, width: float, height: float, colours: np.ndarray) -> None:
    """Fill a rectangle with colours (K, 3) in sRGB from its bottom to its top."""
    levels = np.linspace(y, y + height, len(colours))
    left = np.column_stack([np.full(len(levels), x), levels])
    corners = np.concatenate([left, left + (width, 0)]).astype(np.float32)
    shades = np.column_stack([np.tile(colours, (2, 1)), np.ones(2 * len(levels))]).astype(np.float32)
    low = np.arange(len(levels) - 1, dtype=np.int32)
    right = low + len(levels)
    triangles = np.concatenate(
        [np.column_stack([low, right, right + 1]), np.column_stack([low, right + 1, low + 1])]
    ).astype(np.int32)
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": corners, "color": shades}, indices=triangles)
    batch.draw(shader)


def polyline(points: np.ndarray, colour: Colour, width: float) -> None:
    """Draw a line through points (K, 2); NaN breaks it."""
    known = np.isfinite(points).all(axis=1)
    for run in np.split(np.arange(len(points)), np.flatnonzero(np.diff(known)) + 1):
        if len(run) > 1 and known[run[0]]:
            _strip(points[run], colour, width)


def ring(x: float, y: float, radius: float, colour: Colour, width: float) -> None:
    """Draw a circle."""
    angles = np.linspace(0, 2 * np.pi, 33)
    _strip(np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)]), colour, width)


def disc(x: float, y: float, radius: float, colour: Colour) -> None:
    """Fill a circle."""
    angles = np.linspace(0, 2 * np.pi, 33)
    rim = np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])
    corners = np.concatenate([[(x, y)], rim]).astype(np.float32)
    slices = [(0, number, number + 1) for number in range(1, len(rim))]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": corners}, indices=slices)
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("color", colour)
    batch.draw(shader)


def width_of(words: str, size: float) -> float:
    """Width of one line of text, pixels."""
    blf.size(FONT, size)
    return blf.dimensions(FONT, words)[0]


def text(x: float, y: float, words: str, size: float, colour: Colour, align: str = "LEFT") -> float:
    """Write one line with its baseline at y; returns its width."""
    blf.size(FONT, size)
    width = blf.dimensions(FONT, words)[0]
    shift = {"LEFT": 0.0, "CENTER": width / 2, "RIGHT": width}[align]
    blf.color(FONT, *colour)
    blf.position(FONT, round(x - shift), round(y), 0)
    blf.draw(FONT, words)
    return width


def clipped(words: str, width: float, size: float) -> str:
    """A text cut so that it is no wider than this."""
    blf.size(FONT, size)
    if blf.dimensions(FONT, words)[0] <= width:
        return words
    while words and blf.dimensions(FONT, words + "…")[0] > width:
        words = words[:-1]
    return words.rstrip() + "…"


def _strip(points: Sequence | np.ndarray, colour: Colour, width: float) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    corners = np.column_stack([points, np.zeros(len(points))]).astype(np.float32)
    batch = batch_for_shader(shader, "LINE_STRIP", {"pos": corners})
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", colour)
    batch.draw(shader)
