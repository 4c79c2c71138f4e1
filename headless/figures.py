# SPDX-License-Identifier: GPL-3.0-or-later
"""Finished pictures of heatmaps and chosen places, ready for a slide or a paper."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from blender_addon.w2w.core.colours import COLOUR_MAP, colour_table
from blender_addon.w2w.core.files import atomic_write

DPI = 200
INK, FAINT, HAIRLINE, ACCENT = "#1d2530", "#7a8391", "#d9dde3", "#31688e"
OTHER_SCRIPTS = ("Noto Sans CJK SC", "Noto Sans CJK JP", "Microsoft YaHei", "PingFang SC", "Noto Sans Arabic")
FONT = ["DejaVu Sans", *(name for name in OTHER_SCRIPTS if name in fontManager.get_font_names())]
"""The first comes with matplotlib, so that a figure looks the same on every machine; the others
are for letters that it lacks."""

MARGIN = 0.45
"""White edge around everything, inches."""

HEADER = 0.78
"""Height of the title and subtitle, inches."""

VIEW_SIZE = 4.3
"""Height that a square view is drawn with, inches."""

BAR_COLUMN = 1.05
LIST_COLUMN = 3.7
ROW, BAR = 0.52, 0.06
"""Height of a row of the list, where there is room, and of its bar, inches."""

BADGE = 0.088
"""Radius of a numbered marker, inches."""

SIDES = {"Front": ("R", "L"), "Back": ("L", "R")}
"""Which of the body's sides is on the left and on the right of a view."""

Place = tuple[int, float, float]
"""Index of a view, and the column and row of a pixel in it."""


def heatmap_figure(
    path: str | Path,
    views: Sequence[np.ndarray],
    title: str,
    low: float,
    high: float,
    label: str = "F1",
    subtitle: str = "",
    view_names: Sequence[str] = ("Front", "Back"),
    colour_map: str = COLOUR_MAP,
) -> None:
    """Write a picture of a heatmap: the views side by side, a title and a labelled colour bar.

    Parameters
    ----------
    path : str or Path
        The PNG file to write.
    views : sequence of ndarray, shape (H, W, 4), uint8
        From `BodyRenderer.render`.
    title : str
        What the heatmap is of, such as the activity.
    low, high : float
        Scores at the two ends of the colour bar.
    label : str
        What the colours stand for.
    subtitle : str
        A second, quieter line.
    view_names : sequence of str
        What to write under each view.
    colour_map : str
        The colour map that the views were coloured with.
    """
    crop = _common_crop(views)
    figure, left = _page(views, crop, BAR_COLUMN, title, subtitle)
    _draw_views(figure, views, crop, view_names)
    _draw_bar(figure, left + 0.3, low, high, label, colour_map)
    _save(figure, path)


def subset_figure(
    path: str | Path,
    views: Sequence[np.ndarray],
    title: str,
    places: Sequence[Place],
    names: Sequence[str],
    scores: Sequence[float],
    label: str = "Mean F1",
    target: float | None = None,
    subtitle: str = "",
    view_names: Sequence[str] = ("Front", "Back"),
    scale: tuple[float, float] | None = None,
    colour_map: str = COLOUR_MAP,
) -> None:
    """Write a picture of chosen places: numbered markers on the body and a list beside it.

    Parameters
    ----------
    path : str or Path
        The PNG file to write.
    views : sequence of ndarray, shape (H, W, 4), uint8
        From `BodyRenderer.render`.
    title : str
        What was chosen.
    places : sequence of (view, column, row)
        Where each place is, in order of choice, from `BodyRenderer.locate`.
    names : sequence of str
        Body region of each place.
    scores : sequence of float, each 0 to 1
        Score that the places up to and with this one reach together.
    label : str
        What the scores are.
    target : float, optional
        The score that was asked for, drawn as a line.
    subtitle : str
        A second, quieter line.
    view_names : sequence of str
        What to write under each view.
    scale : (low, high), optional
        Scores at the two ends of a colour bar, where the body is coloured by score.
    colour_map : str
        The colour map that the views were coloured with.

    Raises
    ------
    ValueError
        If places, names and scores differ in number.
    """
    if not len(places) == len(names) == len(scores):
        raise ValueError(
            f"places ({len(places)}), names ({len(names)}) and scores ({len(scores)}) must be as many"
        )
    crop = _common_crop(views)
    bar = BAR_COLUMN if scale else 0.0
    figure, left = _page(views, crop, bar + LIST_COLUMN, title, subtitle)
    axes = _draw_views(figure, views, crop, view_names)
    if scale:
        _draw_bar(figure, left + 0.3, *scale, label, colour_map)
    pixels_an_inch = (crop[1] - crop[0]) / VIEW_SIZE
    for number, view in enumerate(axes):
        here = [index for index, place in enumerate(places) if place[0] == number]
        _draw_markers(
            view, np.array([places[index][1:] for index in here]).reshape(-1, 2), here, pixels_an_inch
        )
    _draw_list(figure, left + bar + 0.3, names, scores, label, target)
    _save(figure, path)


def _common_crop(views: Sequence[np.ndarray]) -> tuple[int, int, int, int]:
    """Rows and columns (top, bottom, left, right) that hold the body in every view."""
    covered = np.any([view[..., 3] > 0 for view in views], axis=0)
    rows, columns = np.flatnonzero(covered.any(axis=1)), np.flatnonzero(covered.any(axis=0))
    if not rows.size:
        return 0, covered.shape[0], 0, covered.shape[1]
    return int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1


def _page(
    views: Sequence[np.ndarray], crop: tuple[int, int, int, int], column: float, title: str, subtitle: str
) -> tuple[Figure, float]:
    """An empty page with its title, and where the right column starts, inches."""
    top, bottom, first, last = crop
    view_width = VIEW_SIZE * (last - first) / (bottom - top)
    left = MARGIN + len(views) * view_width + (len(views) - 1) * MARGIN
    width, height = left + column + MARGIN, MARGIN * 2 + HEADER + VIEW_SIZE
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    heading = _write(figure, MARGIN, height - MARGIN, title, size=17, weight="bold", va="top")
    _fit(figure, heading, width - 2 * MARGIN)
    if subtitle:
        line = _write(figure, MARGIN, height - MARGIN - 0.36, subtitle, size=9.5, color=FAINT, va="top")
        _fit(figure, line, width - 2 * MARGIN)
    return figure, left


def _draw_views(
    figure: Figure, views: Sequence[np.ndarray], crop: tuple[int, int, int, int], names: Sequence[str]
) -> list[Axes]:
    top, bottom, first, last = crop
    view_width = VIEW_SIZE * (last - first) / (bottom - top)
    drawn = []
    for number, (view, name) in enumerate(zip(views, names, strict=True)):
        left = MARGIN + number * (view_width + MARGIN)
        axes = _axes(figure, left, MARGIN, view_width, VIEW_SIZE)
        axes.imshow(view, interpolation="lanczos", aspect="auto", extent=(0, view.shape[1], view.shape[0], 0))
        axes.set(xlim=(first, last), ylim=(bottom, top))
        _write(figure, left, MARGIN + 0.02, name, size=9.5, color=FAINT, va="bottom")
        _draw_sides(axes, view, SIDES.get(name, ("", "")))
        drawn.append(axes)
    return drawn


def _draw_sides(axes: Axes, view: np.ndarray, sides: tuple[str, str]) -> None:
    """A faint letter below each hand: which side of the body it is."""
    covered = view[..., 3] > 127
    columns = np.flatnonzero(covered.any(axis=0))
    if not columns.size:
        return
    reach = max((columns[-1] - columns[0]) // 12, 1)
    for edge, inward, letter in ((columns[0], 1, sides[0]), (columns[-1], -1, sides[1])):
        tip = covered[:, min(edge, edge + inward * reach) : max(edge, edge + inward * reach) + 1]
        lowest = np.flatnonzero(tip.any(axis=1))[-1]
        axes.annotate(
            letter, (edge + inward * reach / 2, lowest), (0, -6), textcoords="offset points", ha="center",
            va="top", fontsize=8.5, color=FAINT, fontfamily=FONT,
        )  # fmt: skip


def _draw_bar(figure: Figure, left: float, low: float, high: float, label: str, colour_map: str) -> None:
    bottom, height = MARGIN + VIEW_SIZE * 0.2, VIEW_SIZE * 0.6
    axes = _axes(figure, left, bottom, 0.15, height)
    span = (low, high) if high > low else (low - 0.5, low + 0.5)
    axes.imshow(colour_table(colour_map)[::-1, None], aspect="auto", extent=(0, 1, *span))
    axes.set_axis_on()
    axes.yaxis.tick_right()
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]) if high > low else MaxNLocator(1))
    if not high > low:
        axes.set_yticks([low], [f"{low:.2f}"])
    else:
        axes.yaxis.set_major_formatter(ScalarFormatter(useOffset=False))
    axes.set_xticks([])
    axes.tick_params(length=0, pad=5, labelsize=9.5, labelcolor=INK, labelfontfamily=FONT)
    for spine in axes.spines.values():
        spine.set_visible(False)
    _write(figure, left, bottom + height + 0.2, label, size=11, weight="bold")


def _draw_markers(axes: Axes, anchors: np.ndarray, numbers: Sequence[int], scale: float) -> None:
    """Numbered badges, pushed apart where they would overlap, each tied to its dot."""
    badges = _apart(anchors, 2.3 * BADGE * scale)
    for anchor, badge, number in zip(anchors, badges, numbers, strict=True):
        if np.linalg.norm(badge - anchor) > 0.5 * BADGE * scale:
            axes.plot(*np.transpose([anchor, badge]), color=INK, linewidth=0.8, clip_on=False, zorder=3)
            axes.plot(*anchor, "o", color=INK, markersize=2.6, clip_on=False, zorder=3)
        _draw_badge(axes, badge, number + 1)


def _draw_badge(axes: Axes, centre: Sequence[float], number: int) -> None:
    """A white disc with a number, the same size on every page."""
    points = 2 * BADGE * 72
    axes.plot(
        *centre, "o", markersize=points, color="white", markeredgecolor=INK, markeredgewidth=1.1,
        clip_on=False, zorder=4,
    )  # fmt: skip
    axes.annotate(
        str(number), centre, ha="center", va="center_baseline", fontsize=8, fontweight="bold", color=INK,
        fontfamily=FONT, annotation_clip=False, zorder=5,
    )  # fmt: skip


def _draw_list(
    figure: Figure,
    left: float,
    names: Sequence[str],
    scores: Sequence[float],
    label: str,
    target: float | None,
    bottom: float = MARGIN,
    height: float = VIEW_SIZE,
) -> None:
    """One row a place: its badge, its name, and a bar of the score reached with it."""
    width = LIST_COLUMN - 0.3
    row = min(ROW, (height - 0.55) / max(len(names), 1))
    axes = _axes(figure, left, bottom, width, height)
    axes.set(xlim=(0, width), ylim=(0, height))
    start, stop, top = 0.34, width - 0.45, height - 0.3
    axes.text(start, height - 0.12, f"{label} reached", fontsize=9.5, color=FAINT, fontfamily=FONT)
    style = {"color": INK, "fontfamily": FONT, "fontsize": 10 if row > 0.4 else 9}
    for number, (name, score) in enumerate(zip(names, scores, strict=True)):
        bar = top - (number + 0.5) * row - 0.13
        _draw_badge(axes, (0.1, bar + 0.1), number + 1)
        _fit(figure, axes.text(start, bar + 0.115, name, **style), width - start)
        axes.add_patch(Rectangle((start, bar), stop - start, BAR, color=HAIRLINE, linewidth=0))
        axes.add_patch(Rectangle((start, bar), (stop - start) * score, BAR, color=ACCENT, linewidth=0))
        axes.text(stop + 0.1, bar + BAR / 2, f"{score:.2f}", va="center_baseline", **style)
        if target is not None:
            x = start + (stop - start) * target
            axes.plot([x, x], [bar - 0.02, bar + BAR + 0.02], color=INK, linewidth=1.2, solid_capstyle="butt")
    if target is not None and len(names):
        axes.text(
            start + (stop - start) * target, bar - 0.17, f"target {target:.2f}", fontsize=8.5, color=FAINT,
            ha="center", fontfamily=FONT,
        )  # fmt: skip


def _apart(anchors: np.ndarray, gap: float, rounds: int = 200) -> np.ndarray:
    """Positions near the anchors, at least `gap` from one another."""
    # a spiral of tiny offsets, so that equal anchors have a direction to part in
    turns = np.arange(len(anchors)) * 2.4
    positions = anchors + 1e-3 * gap * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    for _ in range(rounds):
        offsets = positions[:, None] - positions[None, :]
        lengths = np.linalg.norm(offsets, axis=-1)
        np.fill_diagonal(lengths, np.inf)
        overlap = np.clip(gap - lengths, 0, None)
        if not overlap.any():
            break
        positions = positions + (offsets * (0.51 * overlap / lengths)[..., None]).sum(axis=1)
    return positions


def _axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes without frame or ticks, placed in inches."""
    page = figure.get_size_inches()
    axes = figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))
    axes.set_axis_off()
    return axes


def _write(
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


def _fit(figure: Figure, text: Text, width: float) -> None:
    """Shrink a text until it is no wider than so many inches."""
    renderer = figure.canvas.get_renderer()
    # hinting makes widths jump, so one step may not be enough
    while (extent := text.get_window_extent(renderer).width / DPI) > width:
        text.set_fontsize(min(width / extent, 0.98) * text.get_fontsize())


def _save(figure: Figure, path: str | Path) -> None:
    """Write the PNG whole or not at all, without the date and program that would change its bytes."""
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
