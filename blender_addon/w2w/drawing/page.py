# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of pictures: things placed in inches, numbered markers on the body, and the list next to it."""

import io
import zlib
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from matplotlib.patches import Rectangle
from matplotlib.style import context
from matplotlib.text import Text
from PIL import Image

from ..core.files import atomic_write

OWN_STYLE = context(["default", {"text.parse_math": False}])
"""Decorates what draws: no `matplotlibrc`, not even of the current directory, changes a figure, and a name
with two dollar signs is no formula."""

DPI = 200
PACKED = {"compress_level": 1, "compress_type": zlib.Z_RLE, "dpi": (DPI, DPI)}
"""PNGs are packed by run lengths: three quarters of the usual time, and no larger."""

INK, FAINT, HAIRLINE, ACCENT = "#1d2530", "#7a8391", "#d9dde3", "#31688e"
OTHER_SCRIPTS = ("Noto Sans CJK SC", "Noto Sans CJK JP", "Microsoft YaHei", "PingFang SC", "Noto Sans Arabic")
FONT = ["DejaVu Sans", *(name for name in OTHER_SCRIPTS if name in fontManager.get_font_names())]
"""The first comes with matplotlib, so that figures look the same everywhere; the others have letters that it
lacks."""

SHAPES = {"WIDE": 16 / 9, "SQUARE": 1.0}
"""Widths of slides, in their heights."""

MARGIN = 0.45
"""White edge around everything, inches."""


def axes_at(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes without frame or ticks, placed in inches."""
    page = figure.get_size_inches()
    axes = figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))
    axes.set_axis_off()
    return axes


def lay(
    figure: Figure, picture: np.ndarray, left: float, bottom: float, width: float, height: float
) -> Artist:
    """A picture (H, W, 4), uint8, on the page's own pixels, placed in inches; beneath all axes.

    If it has as many pixels, they are those of the page; else Pillow scales it, in a small part of
    the time that matplotlib's `imshow` takes.
    """
    edges = np.rint(np.array([left, bottom, left + width, bottom + height]) * DPI).astype(int)
    size = (int(edges[2] - edges[0]), int(edges[3] - edges[1]))
    if size != picture.shape[1::-1]:
        whole = Image.fromarray(np.ascontiguousarray(picture))
        picture = np.asarray(whole.resize(size, Image.Resampling.LANCZOS))
    return figure.add_artist(_PagePixels(picture[::-1], int(edges[0]), int(edges[1])))


class _PagePixels(Artist):
    """Pixels (H, W, 4), uint8, the lower row first, put on the page as they are.

    `Figure.figimage` puts them through its colour scales and resamples them first.
    """

    zorder = -1

    def __init__(self, pixels: np.ndarray, left: int, bottom: int) -> None:
        super().__init__()
        self._pixels, self._left, self._bottom = pixels, left, bottom

    def draw(self, renderer: RendererBase) -> None:
        context = renderer.new_gc()
        scale = self.figure.dpi / DPI  # pages of vectors count in points
        renderer.draw_image(context, self._left * scale, self._bottom * scale, self._pixels)
        context.restore()


def write(figure: Figure, x: float, y: float, text: str, size: float, color: str = INK, **style: Any) -> Text:
    """Text on the page, placed in inches."""
    width, height = figure.get_size_inches()
    return figure.text(x / width, y / height, text, fontsize=size, color=color, fontfamily=FONT, **style)


def canvas_of(figure: Figure) -> FigureCanvasAgg:
    """The figure's canvas, on which pages are drawn without a window."""
    assert isinstance(figure.canvas, FigureCanvasAgg)
    return figure.canvas


def drawn_on(figure: Figure) -> Image.Image:
    """What was drawn on the figure's canvas; opaque, which is a quarter less to pack."""
    return Image.fromarray(np.asarray(canvas_of(figure).buffer_rgba())).convert("RGB")


def shaped(picture: Image.Image, shape: str, around: str) -> Image.Image:
    """A picture with room of a colour around it where its shape is another."""
    (width, height), ratio = picture.size, SHAPES[shape]
    size = max(width, round(height * ratio)), max(height, round(width / ratio))
    whole = Image.new(picture.mode, size, around)
    whole.paste(picture, ((size[0] - width) // 2, (size[1] - height) // 2))
    return whole


def fit(figure: Figure, text: Text, width: float) -> None:
    """Shrink a text until it is at most `width` inches wide."""
    renderer = canvas_of(figure).get_renderer()
    # hinting makes widths jump, so one step may not be enough
    while (extent := text.get_window_extent(renderer).width / DPI) > width:
        text.set_fontsize(min(width / extent, 0.98) * float(text.get_fontsize()))


class Picture(Figure):
    """A figure that a notebook shows by itself."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()


def save(figure: Figure, path: str | Path) -> None:
    """Write the file whole or not at all, without the date and program that would change its bytes.

    The suffix decides the kind of file, as Matplotlib knows it.
    """
    kind = Path(path).suffix[1:].lower() or "png"
    with atomic_write(path) as stream:
        if kind == "png":
            canvas_of(figure).draw()
            drawn_on(figure).save(stream, format="png", **PACKED)
        else:
            undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
            figure.savefig(stream, format=kind, metadata=undated)


LIST_COLUMN = 3.7
ROW, BAR = 0.52, 0.06
"""Height of a row of the list, if there is room, and of its bar, inches."""

CARD_ROW, CARD_LETTERS = 1.2, 56
"""Height of a row with its tape-measure card, inches, and letters in a line of a card."""

BADGE = 0.088
"""Radius of a numbered marker, inches."""

Marker = tuple[int, float, float]
"""Index of a view, and the column and row of a pixel in it."""


def draw_markers(axes: Axes, anchors: np.ndarray, numbers: Sequence[int], scale: float) -> None:
    """Numbered badges, pushed apart if they would overlap, each tied to its dot."""
    badges = apart(anchors, 2.3 * BADGE * scale)
    for anchor, badge, number in zip(anchors, badges, numbers, strict=True):
        if np.linalg.norm(badge - anchor) > 0.5 * BADGE * scale:
            axes.plot(*np.transpose([anchor, badge]), color=INK, linewidth=0.8, clip_on=False, zorder=3)
            axes.plot(*anchor, "o", color=INK, markersize=2.6, clip_on=False, zorder=3)
        draw_badge(axes, badge, number + 1)


def draw_badge(axes: Axes, centre: tuple[float, float], number: int) -> None:
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


class SensorList(NamedTuple):
    """Sensors in order of choice, each with the score (0 to 1) of all up to it, and its place in words."""

    names: Sequence[str]
    scores: Sequence[float]
    cards: Sequence[str] = ()
    target: float | None = None
    """Score to reach, drawn as a line."""


def draw_list(
    figure: Figure, sensors: SensorList, label: str, corner: tuple[float, float], height: float
) -> None:
    """Draw a row for each sensor: its badge, its name, a bar of the score reached with it, and its card.

    Cards are left out if there is no room for all; `corner` is the lower left one.
    """
    names, scores, cards, target = sensors
    width = LIST_COLUMN - 0.3
    room = (height - 0.55) / max(len(names), 1)
    if room < CARD_ROW:
        cards = ()
    row = min(CARD_ROW if cards else ROW, room)
    axes = axes_at(figure, *corner, width, height)
    axes.set(xlim=(0, width), ylim=(0, height))
    start, stop, top = 0.34, width - 0.45, height - 0.3
    axes.text(start, height - 0.12, f"{label} reached", fontsize=9.5, color=FAINT, fontfamily=FONT)
    style: dict[str, Any] = {"fontfamily": FONT, "color": INK, "fontsize": 10 if row > 0.4 else 9}
    for number, (name, score) in enumerate(zip(names, scores, strict=True)):
        bar = top - number * row - 0.5 * min(row, ROW) - 0.13
        draw_badge(axes, (0.1, bar + 0.1), number + 1)
        fit(figure, axes.text(start, bar + 0.115, name, **style), width - start)
        axes.add_patch(Rectangle((start, bar), stop - start, BAR, color=HAIRLINE, linewidth=0))
        axes.add_patch(Rectangle((start, bar), (stop - start) * score, BAR, color=ACCENT, linewidth=0))
        axes.text(stop + 0.1, bar + BAR / 2, f"{score:.2f}", va="center_baseline", **style)
        if target is not None:
            x = start + (stop - start) * target
            axes.plot([x, x], [bar - 0.02, bar + BAR + 0.02], color=INK, linewidth=1.2, solid_capstyle="butt")
        if cards:
            below = bar - (0.26 if target is not None and number == len(names) - 1 else 0.1)
            lines = fill(cards[number], CARD_LETTERS)
            axes.text(start, below, lines, fontsize=8, color=INK, va="top", linespacing=1.25, fontfamily=FONT)
    if target is not None:
        axes.text(
            start + (stop - start) * target, bar - 0.17, f"target {target:.2f}", fontsize=8.5, color=FAINT,
            ha="center", fontfamily=FONT,
        )  # fmt: skip


def apart(anchors: np.ndarray, gap: float) -> np.ndarray:
    """Positions near the anchors, at least `gap` from one another."""
    # a spiral of tiny offsets, so that equal anchors have a direction to part in
    turns = np.arange(len(anchors)) * 2.4
    positions = anchors + 1e-3 * gap * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    for _ in range(200):
        offsets = positions[:, None] - positions[None, :]
        lengths = np.linalg.norm(offsets, axis=-1)
        np.fill_diagonal(lengths, np.inf)
        overlap = np.clip(gap - lengths, 0, None)
        if not overlap.any():
            break
        positions = positions + (offsets * (0.51 * overlap / lengths)[..., None]).sum(axis=1)
    return positions
