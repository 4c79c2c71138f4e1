# SPDX-License-Identifier: GPL-3.0-or-later
"""What every picture is laid out with: a page in inches, its colours, letters and edges."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from matplotlib.text import Text

from blender_addon.w2w.core.files import atomic_write

DPI = 200
INK, FAINT, HAIRLINE, ACCENT = "#1d2530", "#7a8391", "#d9dde3", "#31688e"
OTHER_SCRIPTS = ("Noto Sans CJK SC", "Noto Sans CJK JP", "Microsoft YaHei", "PingFang SC", "Noto Sans Arabic")
FONT = ["DejaVu Sans", *(name for name in OTHER_SCRIPTS if name in fontManager.get_font_names())]
"""The first comes with matplotlib, so that a figure looks the same on every machine; the others
are for letters that it lacks."""

MARGIN = 0.45
"""White edge around everything, inches."""


def common_crop(views: Sequence[np.ndarray]) -> tuple[int, int, int, int]:
    """Rows and columns (top, bottom, left, right) that hold the body in every view."""
    covered = np.any([view[..., 3] > 0 for view in views], axis=0)
    rows, columns = np.flatnonzero(covered.any(axis=1)), np.flatnonzero(covered.any(axis=0))
    if not rows.size:
        return 0, covered.shape[0], 0, covered.shape[1]
    return int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1


def axes_at(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes without frame or ticks, placed in inches."""
    page = figure.get_size_inches()
    axes = figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))
    axes.set_axis_off()
    return axes


def write(
    figure: Figure,
    x: float,
    y: float,
    text: str,
    size: float,
    color: str = INK,
    weight: str = "normal",
    va: str = "baseline",
) -> Text:
    """Text on the page, placed in inches."""
    page = figure.get_size_inches()
    return figure.text(
        x / page[0], y / page[1], text, fontsize=size, color=color, fontweight=weight, va=va,
        fontfamily=FONT, parse_math=False,
    )  # fmt: skip


def fit(figure: Figure, text: Text, width: float) -> None:
    """Shrink a text until it is no wider than so many inches."""
    renderer = figure.canvas.get_renderer()
    # hinting makes widths jump, so one step may not be enough
    while (extent := text.get_window_extent(renderer).width / DPI) > width:
        text.set_fontsize(min(width / extent, 0.98) * text.get_fontsize())


def save(figure: Figure, path: str | Path) -> None:
    """Write the PNG whole or not at all, without the date and program that would change its bytes."""
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
