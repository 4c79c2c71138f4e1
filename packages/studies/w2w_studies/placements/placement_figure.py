# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's figure 4 of a study: F1 of every activity at every placement, group by group."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from w2w.core.colours import score_colours
from w2w.core.ranking.f1 import FEWEST_CLIPS
from w2w.core.wording import capital
from w2w.drawing.page import DPI, FAINT, FONT, INK, MARGIN, axes_at, fit, save, write

from .score_table import ScoreRow

rcParams["text.parse_math"] = False  # names are a user's words: one with two dollar signs is no formula

CELL_WIDTH, CELL_HEIGHT = 0.62, 0.3
"""Inches."""

LABELS = 2.5
"""Width of the activities' names, inches."""

HEADINGS = 1.15
"""Height of the placements' names, which stand at an angle, inches."""

BLOCK_HEAD, BLOCK_GAP = 0.3, 0.14
TITLE, FOOT = 0.75, 0.5
DARK = 0.45
"""Lightness of a cell below which its figure is white."""


def placement_figure(
    path: str | Path, rows: Sequence[ScoreRow], columns: Sequence[str], common: Sequence[bool], title: str
) -> None:
    """Write the figure: a block a group, a row an activity, a column a placement, the F1 in each cell.

    `path`: the PNG file to write.
    `rows`: of activities, in the order wanted.
    `columns`: the placements.
    `common`: whether wearables are usually worn there; a line parts them from the others.
    """
    blocks = [(group, list(members)) for group, members in groupby(rows, key=lambda row: row.group)]
    wide = len(columns) * CELL_WIDTH
    tall = len(rows) * CELL_HEIGHT + len(blocks) * (BLOCK_HEAD + BLOCK_GAP)
    page = (LABELS + wide + 2 * MARGIN, TITLE + HEADINGS + tall + FOOT + 2 * MARGIN)
    figure = Figure(figsize=page, dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    left, top = MARGIN + LABELS, page[1] - MARGIN
    fit(figure, write(figure, MARGIN, top - 0.2, title, size=13, weight="bold"), page[0] - 2 * MARGIN)
    few = any(row.clips < FEWEST_CLIPS for row in rows)
    note = "F1 on these clips. Bold: cannot be told from the best of its row."
    note += f" *: fewer than {FEWEST_CLIPS} clips." if few else ""
    fit(figure, write(figure, MARGIN, top - 0.45, note, size=9, color=FAINT), page[0] - 2 * MARGIN)
    top -= TITLE + HEADINGS
    _headings(axes_at(figure, left, top, wide, HEADINGS), columns, wide)
    for group, members in blocks:
        height = len(members) * CELL_HEIGHT
        write(figure, MARGIN, top - BLOCK_HEAD + 0.09, _words(group), size=10.5, weight="bold")
        _block(
            axes_at(figure, left, top - BLOCK_HEAD - height, wide, height), members, columns, common, figure
        )
        top -= BLOCK_HEAD + height + BLOCK_GAP
    save(figure, path)


def _headings(axes: Axes, columns: Sequence[str], wide: float) -> None:
    axes.set(xlim=(0, wide), ylim=(0, HEADINGS))
    for number, name in enumerate(columns):
        axes.text(
            (number + 0.5) * CELL_WIDTH, 0.04, name, fontsize=9, color=INK, rotation=40, ha="left",
            va="bottom", rotation_mode="anchor", fontfamily=FONT, clip_on=False,
        )  # fmt: skip


def _block(
    axes: Axes, rows: Sequence[ScoreRow], columns: Sequence[str], common: Sequence[bool], figure: Figure
) -> None:
    scores = np.array([row.f1 for row in rows])
    colours = score_colours(scores, 0.0, 1.0)
    axes.imshow(colours, aspect="auto", extent=(0, len(columns), len(rows), 0), interpolation="nearest")
    for line, row in enumerate(rows):
        name = _words(row.activity) + ("*" if row.clips < FEWEST_CLIPS else "")
        label = axes.text(
            -0.12, line + 0.5, name, fontsize=9, color=INK, ha="right", va="center_baseline",
            fontfamily=FONT, clip_on=False,
        )  # fmt: skip
        fit(figure, label, LABELS - 0.15)
        for column, score in enumerate(row.f1):
            light = colours[line, column] @ [0.299, 0.587, 0.114]
            axes.text(
                column + 0.5, line + 0.5, f"{score:.2f}", fontsize=8.5, ha="center", va="center_baseline",
                color="white" if light < DARK else INK, fontfamily=FONT,
                fontweight="bold" if row.best[column] and row.f1.any() else "normal",
            )  # fmt: skip
    for column in range(1, len(columns)):
        if common[column - 1] != common[column]:
            axes.plot([column, column], [0, len(rows)], color="white", linewidth=4)
    axes.set(xlim=(0, len(columns)), ylim=(len(rows), 0))


def _words(name: str) -> str:
    return capital(name.replace("_", " "))
