# SPDX-License-Identifier: GPL-3.0-or-later
"""The card of a picked patch: its name and rank, F1 by activity, and its signals at the playhead."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.colours import Scale, score_colours
from ..core.imu.recording import ImuRecording
from .canvas import Canvas, Colour, clipped
from .places import Box, Place

WIDTH, FOLDED_WIDTH, MARGIN, LINE = 350, 230, 12, 15
"""Sizes at a scale of 1, pixels."""

TITLE = np.array([280, 27])
"""Width and height of a card that is but a title, pixels at a scale of 1."""

CLOSER, SCORED = 32, 58
"""Width of the corner that closes a card, with the score beside it, pixels at a scale of 1."""

PLOT_HEIGHT, FOLDED_PLOT, PLOT_GAP = 52, 32, 21
PLOTS = ("Acceleration, m/s²", "Angular velocity, rad/s")
"""Titles of the plots."""

MANY_ACTIVITIES = 6
"""With more activities than these, bars stand in two columns."""

BACKGROUND: Colour = (0.07, 0.07, 0.07, 0.9)
PALE: Colour = (1.0, 1.0, 1.0, 0.95)
GREY: Colour = (1.0, 1.0, 1.0, 0.45)
FAINT: Colour = (1.0, 1.0, 1.0, 0.035)
AXES: tuple[Colour, ...] = ((0.90, 0.49, 0.13, 1), (0.16, 0.72, 0.55, 1), (0.42, 0.72, 0.96, 1))
"""x, y and z in the colours of Okabe and Ito (2008), which colour-blind eyes tell apart."""


@dataclass(frozen=True, eq=False)
class HoverCard:
    """The text, scores and signals of a card."""

    mark: str  # letter that the patch has on the body
    colour: Colour
    title: str
    lines: tuple[str, ...]  # below the title
    activities: tuple[str, ...]
    f1: np.ndarray  # (A,), of length 0 before a ranking
    scale: Scale  # of the bars' colours
    recording: ImuRecording | None  # the clip's signals, if baked
    patch: int
    clip: str  # what the signals show, or why there are none
    time: float  # playhead, seconds from the clip's start
    score: str = ""  # beside the title of a card that is no more than that
    limits: tuple[tuple[float, float], ...] = ()  # of the plots, one pair a signal: see `on_one_scale`

    def signals(self) -> tuple[np.ndarray, ...]:
        """Acceleration and angular velocity of the patch, each of shape (T, 3), or () before a bake."""
        shown = self.recording
        return () if shown is None else (shown.acc[:, self.patch], shown.gyr[:, self.patch])

    def sizes(self) -> list[Callable[[float], tuple[float, float]]]:
        """Width and height, pixels, of the whole card, a folded one and a mere title, at a scale."""
        return [self._whole, self._folded, lambda scale: tuple(TITLE * scale)]

    def _whole(self, scale: float) -> tuple[float, float]:
        n_plots = 2 if self.recording is not None else 0
        rows = self._rows() + 1 if self._rows() else 0
        lines = 3 + len(self.lines) + rows
        return WIDTH * scale, scale * (lines * LINE + n_plots * (PLOT_HEIGHT + PLOT_GAP) + 1.5 * MARGIN)

    def _folded(self, scale: float) -> tuple[float, float]:
        below = LINE if self.recording is None else FOLDED_PLOT + PLOT_GAP
        return FOLDED_WIDTH * scale, scale * (2 * LINE + below + MARGIN)

    def boxes(self, stand: Place) -> tuple[Box, Box]:
        """Where the card stands, and where a click closes it."""
        width, height = self.sizes()[stand.form](stand.scale)
        right, top, corner = stand.x + width, stand.y + height, CLOSER * stand.scale
        return Box(stand.x, stand.y, right, top), Box(right - corner, top - min(corner, height), right, top)

    def draw(self, stand: Place, canvas: Canvas) -> None:
        """Draw the card."""
        x, y, scale, form, _ = stand
        (width, height), is_title = self.sizes()[form](scale), form == 2
        canvas.rectangle(x, y, width, height, BACKGROUND)
        canvas.rectangle(x, y, 4 * scale, height, self.colour)
        left, right = x + MARGIN * scale, x + width - MARGIN * scale
        top = y + height - (MARGIN + 8) * scale
        room = right - left - (SCORED if is_title else CLOSER) * scale
        title = clipped(canvas, f"{self.mark}  {self.title}", room, 14 * scale)
        canvas.text(left, top, title, 14 * scale, PALE)
        canvas.text(right, top, "✕", 13 * scale, PALE, "RIGHT")
        if is_title:
            canvas.text(right - 20 * scale, top, self.score, 14 * scale, PALE, "RIGHT")
            return
        is_folded = bool(form)
        top -= 0.2 * LINE * scale
        for line in self.lines[: 1 if is_folded else None]:
            top -= LINE * scale
            canvas.text(left, top, clipped(canvas, line, right - left, 11 * scale), 11 * scale, GREY)
        if not is_folded:
            top = self._bars(canvas, left, right, top - 1.5 * LINE * scale, scale)
        elif self.recording is None:
            top -= LINE * scale
        if not is_folded or self.recording is None:
            canvas.text(left, top, clipped(canvas, self.clip, right - left, 11 * scale), 11 * scale, GREY)
            top -= 6 * scale
        middle, half = (left + right) / 2, MARGIN * scale / 2
        across = ((left, middle - half), (middle + half, right)) if is_folded else ((left, right),) * 2
        for number, (signal, limits) in enumerate(zip(self.signals(), self.limits, strict=True)):
            if number == 0 or not is_folded:
                top -= ((FOLDED_PLOT if is_folded else PLOT_HEIGHT) + PLOT_GAP) * scale
            self._plot(canvas, number, (*across[number], top), scale, signal, limits, is_folded)

    def _rows(self) -> int:
        count = len(self.f1)
        return -(-count // 2) if count > MANY_ACTIVITIES else count

    def _bars(self, canvas: Canvas, left: float, right: float, top: float, scale: float) -> float:
        """Draw a bar an activity; returns the height below them."""
        rows = self._rows()
        if not rows:
            return top
        n_columns = 2 if len(self.f1) > MANY_ACTIVITIES else 1
        column = (right - left + MARGIN * scale) / n_columns
        longest = max(canvas.width_of(activity, 11 * scale) for activity in self.activities)
        label, number = min(longest + 8 * scale, 0.6 * column), 30 * scale
        full = column - label - number - MARGIN * scale
        shades = score_colours(self.f1, self.scale.low, self.scale.high, self.scale.colour_map)
        for index, (activity, f1) in enumerate(zip(self.activities, self.f1, strict=True)):
            x, y = left + (index // rows) * column, top - (index % rows) * LINE * scale
            canvas.text(x, y, clipped(canvas, activity, label - 6 * scale, 11 * scale), 11 * scale, PALE)
            canvas.rectangle(x + label, y - scale, full, 9 * scale, FAINT)
            canvas.rectangle(x + label, y - scale, full * float(f1), 9 * scale, (*shades[index], 1.0))
            canvas.text(x + label + full + number, y, f"{f1:.2f}", 11 * scale, PALE, "RIGHT")
        return top - (rows + 0.5) * LINE * scale

    def _plot(
        self, canvas: Canvas, number: int, place: tuple[float, float, float], scale: float,
        signal: np.ndarray, limits: tuple[float, float], is_folded: bool,
    ) -> None:  # fmt: skip
        """Draw three axes of a signal over the clip, and a cursor at the playhead."""
        (left, right, y), (low, high), rate = place, limits, self.recording.rate if self.recording else 1.0
        height, width = (FOLDED_PLOT if is_folded else PLOT_HEIGHT) * scale, right - left
        now = min(max(self.time, 0.0), (len(signal) - 1) / rate)
        title = clipped(canvas, PLOTS[number], width, 11 * scale)
        canvas.text(left, y + height + 5 * scale, title, 11 * scale, PALE)
        if not is_folded:
            self._values(canvas, right, y + height + 5 * scale, scale, signal[round(now * rate)])
        canvas.rectangle(left, y, width, height, FAINT)
        canvas.text(left + 3 * scale, y + height - 11 * scale, f"{high:g}", 9 * scale, GREY)
        canvas.text(left + 3 * scale, y + 3 * scale, f"{low:g}", 9 * scale, GREY)
        zero = y + height * (0 - low) / (high - low)
        canvas.rectangle(left, zero, width, 1, (1.0, 1.0, 1.0, 0.1))
        times = np.linspace(left, right, len(signal))
        for axis, colour in enumerate(AXES):
            levels = y + height * (signal[:, axis] - low) / (high - low)
            canvas.polyline(np.column_stack([times, levels]), colour, 1.4 * scale)
        cursor = left + width * now * rate / max(len(signal) - 1, 1)
        canvas.rectangle(round(cursor), y, max(scale, 1), height, PALE)

    def _values(self, canvas: Canvas, right: float, y: float, scale: float, sample: np.ndarray) -> None:
        """Write the values at the playhead, each in its axis's colour."""
        for axis in (2, 1, 0):
            value = "lost" if np.isnan(sample[axis]) else f"{sample[axis]:.1f}"
            canvas.text(right, y, f"{'xyz'[axis]} {value}", 10 * scale, AXES[axis], "RIGHT")
            right -= 52 * scale


def on_one_scale(cards: Sequence[HoverCard]) -> list[HoverCard]:
    """The cards with the same limits for plots of the same signal, so that heights can be compared."""
    shown = [signals for card in cards if (signals := card.signals())]
    limits = tuple(_limits(np.concatenate(signals)) for signals in zip(*shown, strict=True))
    return [replace(card, limits=limits) for card in cards]


def _limits(signal: np.ndarray) -> tuple[float, float]:
    """Even limits around zero that the signal stays inside."""
    largest = float(np.nanmax(np.abs(signal))) if np.isfinite(signal).any() else 1.0
    step = 10.0 ** np.floor(np.log10(max(largest, 1e-3)))
    limit = float(next(step * factor for factor in (1, 2, 3, 5, 10) if step * factor >= largest))
    return -limit, limit
