# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's figure of a study: a heatmap an activity, their mean, and the chosen sensors, on one page."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from w2w.core.colours import colour_table
from w2w.drawing import page
from w2w.drawing.body import common_crop

WIDTH = 13.2
"""Width of the page, inches."""

IN_A_ROW = 4
"""Activities side by side."""

GAP, COLUMN_GAP = 0.3, 0.55
HEAD = 0.55
"""Height of a panel's letter and heading, inches."""

CAPTION = 0.5
"""Height of what stands over a single body, inches."""

BETWEEN = 0.06
"""Between a body's front and back, inches."""

FOOT = 0.7
"""Height of the colour bar and the room over it, inches."""

LIST = 3.7
"""Width of the list of sensors, inches."""


@dataclass(frozen=True)
class Map:
    """A heatmap to draw."""

    views: Sequence[np.ndarray]  # (H, W, 4): front and back, from `BodyPictures.coloured`
    title: str
    note: str
    """What it shows, and a quieter line."""


def panel_figure(
    path: str | Path,
    activities: Sequence[Map],
    mean: Map,
    subset: Map,
    markers: Sequence[page.Marker],
    names: Sequence[str],
    scores: Sequence[float],
    scale: tuple[float, float],
    target: float,
) -> None:
    """Write the figure: (a) a heatmap an activity, (b) the mean map, (c) the chosen sensors.

    `path`: the PNG file to write.
    `mean`, `subset`: all maps coloured over the same `scale`.
    `markers`, `names`, `scores`: the chosen sensors, as in `heatmap.subset_figure`.
    `scale`: F1 at the two ends of the colour bar.
    """
    every = [*activities, mean, subset]
    crop = common_crop([view for shown in every for view in shown.views])
    ratio = (crop[3] - crop[2]) / (crop[1] - crop[0])
    cell = (WIDTH - 2 * page.MARGIN - (IN_A_ROW - 1) * GAP) / IN_A_ROW
    small = (cell - BETWEEN) / 2 / ratio
    rows = -(-len(activities) // IN_A_ROW)
    upper = HEAD + rows * (CAPTION + small + GAP)
    wide = (WIDTH - 2 * page.MARGIN - COLUMN_GAP - GAP - LIST) / 2
    large = (wide - BETWEEN) / 2 / ratio
    height = page.MARGIN + upper + HEAD + CAPTION + large + FOOT + page.MARGIN
    figure = Figure(figsize=(WIDTH, height), dpi=page.DPI, facecolor="white")
    FigureCanvasAgg(figure)
    _panel_head(figure, page.MARGIN, height - page.MARGIN, "a", "Each activity by itself")
    for number, shown in enumerate(activities):
        row, column = divmod(number, IN_A_ROW)
        left = page.MARGIN + column * (cell + GAP)
        top = height - page.MARGIN - HEAD - row * (CAPTION + small + GAP)
        _draw_map(figure, shown, crop, (left, top), small, cell)
    top = height - page.MARGIN - upper
    _panel_head(figure, page.MARGIN, top, "b", "The mean over activities")
    _draw_map(figure, mean, crop, (page.MARGIN, top - HEAD), large, wide)
    right = page.MARGIN + wide + COLUMN_GAP
    _panel_head(figure, right, top, "c", "Where to wear")
    views = _draw_map(figure, subset, crop, (right, top - HEAD), large, wide + GAP + LIST)
    pixels_an_inch = (crop[1] - crop[0]) / large
    for number, view in enumerate(views):
        here = [index for index, marker in enumerate(markers) if marker[0] == number]
        anchors = np.array([markers[index][1:] for index in here]).reshape(-1, 2)
        page.draw_markers(view, anchors, here, pixels_an_inch)
    bottom = top - HEAD - CAPTION - large
    sensors = page.SensorList(names, scores, target=target)
    page.draw_list(figure, sensors, "Best-of F1", (right + wide + GAP, bottom), large)
    _draw_scale(figure, scale)
    page.save(figure, path)


def _panel_head(figure: Figure, left: float, top: float, letter: str, heading: str) -> None:
    page.write(figure, left, top - 0.22, letter, size=17, weight="bold")
    page.write(figure, left + 0.28, top - 0.22, heading, size=13)


def _draw_map(
    figure: Figure,
    shown: Map,
    crop: tuple[int, int, int, int],
    corner: tuple[float, float],
    height: float,
    width: float,
) -> list[Axes]:
    """A body from both sides under its title; `corner` is the upper left one."""
    top, bottom, first, last = crop
    left, upper = corner
    page.fit(figure, page.write(figure, left, upper - 0.1, shown.title, size=11, weight="bold"), width)
    page.fit(figure, page.write(figure, left, upper - 0.29, shown.note, size=9, color=page.FAINT), width)
    wide = height * (last - first) / (bottom - top)
    drawn = []
    for number, view in enumerate(shown.views):
        axes = page.axes_at(figure, left + number * (wide + BETWEEN), upper - CAPTION - height, wide, height)
        axes.imshow(view, interpolation="lanczos", aspect="auto", extent=(0, view.shape[1], view.shape[0], 0))
        axes.set(xlim=(first, last), ylim=(bottom, top))
        drawn.append(axes)
    return drawn


def _draw_scale(figure: Figure, scale: tuple[float, float]) -> None:
    """One colour bar for all maps, along the foot."""
    low, high = scale if scale[1] > scale[0] else (scale[0] - 0.5, scale[0] + 0.5)
    axes = page.axes_at(figure, page.MARGIN, page.MARGIN + 0.12, 4.2, 0.15)
    axes.imshow(colour_table()[None], aspect="auto", extent=(low, high, 0, 1))
    axes.set_axis_on()
    axes.set_yticks([])
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.tick_params(length=0, pad=4, labelsize=9, labelcolor=page.INK, labelfontfamily=page.FONT)
    for spine in axes.spines.values():
        spine.set_visible(False)
    page.write(
        figure,
        page.MARGIN + 4.35,
        page.MARGIN + 0.15,
        "F1: the same colours in all maps; each body from the front, then from behind",
        9,
        page.FAINT,
    )
