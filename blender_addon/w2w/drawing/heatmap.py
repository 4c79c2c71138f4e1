# SPDX-License-Identifier: GPL-3.0-or-later
"""Finished pictures of heatmaps and chosen sensors, ready for a slide or a paper."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, ScalarFormatter
from PIL import Image

from ..core.body.body import Body
from ..core.colours import Scale, colour_table
from ..core.files import atomic_write
from ..core.imu.recording import ImuRecording
from ..core.patches.patches import PatchSet
from . import page
from .body import BodyPictures, common_crop, size_for
from .signal_figure import moving_signals

VIEW_SIZE = 4.3
"""Height that a square view is drawn with, inches."""

VIEW_PIXELS = round(VIEW_SIZE * page.DPI)
"""Height of a body, pixels, whose picture needs no scaling."""

SPARE = 4
"""Pixels by which a body may be lower: it then gets a wider edge instead of being scaled."""

HEADER = 0.78
"""Height of the title and subtitle, inches."""

BAR_COLUMN = 1.3

Crop = tuple[int, int, int, int]
"""First and last row, first and last column of a view that are shown."""

SIDES = {"Front": ("R", "L"), "Back": ("L", "R")}
"""Which of the body's sides is on the left and on the right of a view."""


def draw_heatmap(
    path: str | Path | None,
    body: Body,
    patches: PatchSet,
    scores: np.ndarray,
    title: str,
    scale: Scale,
    subtitle: str = "",
) -> Figure:
    """Draw scores of patches on the front and the back of a body.

    Parameters
    ----------
    path : str or Path or None
        The suffix decides the kind of file, as Matplotlib knows it; None writes none.
    body : Body, V vertices
    patches : PatchSet, N patches
        Of the same body.
    scores : ndarray, shape (N,)
        NaN where a patch has none.
    title : str
    scale : Scale
    subtitle : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    views = BodyPictures(body, size_for(body, VIEW_PIXELS)).coloured(scale.colours(patches, scores))
    return heatmap_figure(path, views, title, scale, subtitle)


@page.OWN_STYLE
def heatmap_figure(
    path: str | Path | None, views: Sequence[np.ndarray], title: str, scale: Scale, subtitle: str = ""
) -> Figure:
    """A picture of a heatmap, written if a path is given: front and back under a title, a colour bar.

    `views` are pictures (H, W, 4), uint8, of `BodyPictures.coloured`. The path's suffix decides the kind of
    file, as Matplotlib knows it.
    """
    figure, _, _ = _page(views, title, subtitle, scale)
    if path is not None:
        page.save(figure, path)
    return figure


@page.OWN_STYLE
def subset_figure(
    path: str | Path | None,
    views: Sequence[np.ndarray],
    title: str,
    scale: Scale,
    markers: Sequence[page.Marker],
    sensors: page.SensorList,
    subtitle: str = "",
) -> Figure:
    """A picture of chosen sensors, written if a path is given: a heatmap with markers, a list next to it.

    `markers` are places of the sensors, in order of choice, from `BodyPictures.locate`.
    """
    figure, crop = _with_list(views, title, subtitle, scale, sensors)
    for number in range(len(views)):
        _draw_markers(figure, number, crop, markers)
    if path is not None:
        page.save(figure, path)
    return figure


def draw_slide(path: Path, views: Sequence[np.ndarray], shape: str, on_page: dict[str, Any] | None) -> None:
    """Write pictures of a body side by side as a PNG file of one of `page.SHAPES`.

    They stand on a `subset_figure` with its other arguments `on_page`, or on nothing.
    """
    if on_page is None:
        top, bottom, first, last = common_crop(views)
        alone = np.concatenate([each[top:bottom, first:last] for each in views], axis=1)
        whole = page.shaped(Image.fromarray(alone), shape, "#ffffff00")
    else:
        figure = subset_figure(None, views, **on_page)
        page.canvas_of(figure).draw()
        whole = page.shaped(page.drawn_on(figure), shape, "white")
    with atomic_write(path) as stream:
        whole.save(stream, format="png", compress_level=1)


@page.OWN_STYLE
def moving_figure(
    title: str, scale: Scale, sensors: page.SensorList, subtitle: str, recording: ImuRecording | None = None
) -> Callable[[np.ndarray, Sequence[page.Marker], float], Image.Image]:
    """A function that draws frames of a film: `subset_figure` around one view, signals at a time below it.

    Views have shape (VIEW_PIXELS, VIEW_PIXELS, 4), times are in seconds. All but view, markers and the line
    that stands at the time is drawn once.
    """
    white = np.full((VIEW_PIXELS, VIEW_PIXELS, 4), 255, dtype=np.uint8)
    figure, crop = _with_list([white], title, subtitle, scale, sensors)
    canvas = page.canvas_of(figure)
    canvas.draw()
    still, (width, height) = canvas.copy_from_bbox(figure.bbox), canvas.get_width_height()
    signals = recording and moving_signals(recording, width)

    @page.OWN_STYLE
    def frame(view: np.ndarray, markers: Sequence[page.Marker], time: float) -> Image.Image:
        canvas.restore_region(still)
        body = page.lay(figure, view, *_place(0, crop))
        for moving in (body, _draw_markers(figure, 0, crop, markers)):
            moving.draw(canvas.get_renderer())
            moving.remove()
        drawn = page.drawn_on(figure)
        if signals:
            below = signals(time)
            drawn = drawn.crop((0, 0, width, height + below.height))
            drawn.paste(below, (0, height))
        return drawn

    return frame


def _with_list(
    views: Sequence[np.ndarray], title: str, subtitle: str, scale: Scale, sensors: page.SensorList
) -> tuple[Figure, Crop]:
    """A page with a list of sensors; the crop of the views."""
    figure, crop, column = _page(views, title, subtitle, scale, page.LIST_COLUMN)
    page.draw_list(figure, sensors, scale.title, (column, page.MARGIN), VIEW_SIZE)
    return figure, crop


def _draw_markers(figure: Figure, number: int, crop: Crop, markers: Sequence[page.Marker]) -> Axes:
    """Numbered badges on a view."""
    top, bottom, first, last = crop
    axes = page.axes_at(figure, *_place(number, crop))
    axes.set(xlim=(first, last), ylim=(bottom, top))
    here = [index for index, marker in enumerate(markers) if marker[0] == number]
    anchors = np.array([markers[index][1:] for index in here]).reshape(-1, 2)
    page.draw_markers(axes, anchors, here, (bottom - top) / VIEW_SIZE)
    return axes


def _crop(views: Sequence[np.ndarray]) -> Crop:
    """Rows and columns to show: those that hold the body, or a few more if that avoids scaling."""
    top, bottom, first, last = common_crop(views)
    spare = VIEW_PIXELS - (bottom - top)
    if 0 < spare <= SPARE and len(views[0]) >= VIEW_PIXELS:
        top = min(max(top - spare // 2, 0), len(views[0]) - VIEW_PIXELS)
        bottom = top + VIEW_PIXELS
    return top, bottom, first, last


def _place(number: int, crop: Crop) -> tuple[float, float, float, float]:
    """Left, bottom, width and height of a view on the page, inches."""
    top, bottom, first, last = crop
    width = VIEW_SIZE * (last - first) / (bottom - top)
    return page.MARGIN + number * (width + page.MARGIN), page.MARGIN, width, VIEW_SIZE


def _page(
    views: Sequence[np.ndarray], title: str, subtitle: str, scale: Scale, column: float = 0.0
) -> tuple[Figure, Crop, float]:
    """A page with title, views and colour bar; the crop of the views, and the start of a further column."""
    crop = _crop(views)
    last_left, _, view_width, _ = _place(len(views) - 1, crop)
    left = last_left + view_width
    width, height = left + (BAR_COLUMN + column) + page.MARGIN, page.MARGIN * 2 + HEADER + VIEW_SIZE
    figure = page.Picture(figsize=(width, height), dpi=page.DPI, facecolor="white")
    FigureCanvasAgg(figure)
    top = height - page.MARGIN
    heading = page.write(figure, page.MARGIN, top, title, size=17, weight="bold", va="top")
    line = page.write(figure, page.MARGIN, top - 0.36, subtitle, size=9.5, color=page.FAINT, va="top")
    for text in (heading, line):
        page.fit(figure, text, width - 2 * page.MARGIN)
    first_row, last_row, first, last = crop
    names = SIDES if len(views) > 1 else {"": ()}
    for number, (view, name) in enumerate(zip(views, names, strict=True)):
        place, shown = _place(number, crop), view[first_row:last_row, first:last]
        page.lay(figure, shown, *place)
        page.write(figure, place[0], page.MARGIN + 0.02, name, size=9.5, color=page.FAINT, va="bottom")
        if name:
            _draw_sides(figure, shown, place, SIDES[name])
    _draw_bar(figure, left + 0.3, scale)
    return figure, crop, left + BAR_COLUMN + 0.3


def _draw_sides(
    figure: Figure, shown: np.ndarray, place: tuple[float, float, float, float], sides: tuple[str, str]
) -> None:
    """Write a faint letter below each hand for its side of the body."""
    covered = shown[..., 3] > 127
    columns = np.flatnonzero(covered.any(axis=0))
    left, bottom, width, height = place
    reach = max((columns[-1] - columns[0]) // 12, 1)
    for edge, inward, letter in ((columns[0], 1, sides[0]), (columns[-1], -1, sides[1])):
        tip = covered[:, min(edge, edge + inward * reach) : max(edge, edge + inward * reach) + 1]
        lowest = np.flatnonzero(tip.any(axis=1))[-1]
        x = left + width * (edge + inward * reach / 2) / shown.shape[1]
        y = bottom + height * (1 - lowest / shown.shape[0]) - 6 / 72
        text = page.write(figure, x, y, letter, 8.5, page.FAINT, va="top", ha="center")
        text.set_zorder(-0.5)  # above the view, below its markers


def _draw_bar(figure: Figure, left: float, scale: Scale) -> None:
    bottom, height = page.MARGIN + VIEW_SIZE * 0.2, VIEW_SIZE * 0.6
    axes = page.axes_at(figure, left, bottom, 0.15, height)
    low, high = scale.low, scale.high
    span = (low, high) if high > low else (low - 0.5, low + 0.5)
    axes.imshow(colour_table(scale.colour_map)[::-1, None], aspect="auto", extent=(0, 1, *span))
    axes.set_axis_on()
    axes.yaxis.tick_right()
    if high > low:
        axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axes.yaxis.set_major_formatter(ScalarFormatter(useOffset=False))
    else:
        axes.set_yticks([low], [f"{low:.2f}"])
    axes.set_xticks([])
    axes.tick_params(length=0, pad=5, labelsize=9.5, labelcolor=page.INK, labelfontfamily=page.FONT)
    axes.spines[:].set_visible(False)
    page.write(figure, left, bottom + height + 0.2, scale.title, size=11, weight="bold")
    note = scale.note.replace(" ", "\n", 1)
    page.write(figure, left, bottom - 0.22, note, size=8.5, color=page.FAINT, va="top")
