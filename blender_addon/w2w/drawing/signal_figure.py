# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of one sensor's signal: specific force, angular velocity and the other readings."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image, ImageDraw

from ..core.files import atomic_write
from ..core.imu.recording import ImuRecording, Reading
from .page import DPI, FAINT, HAIRLINE, INK, MARGIN, OWN_STYLE, axes_at, draw_badge, drawn_on, write

COLOURS = {"w": "#7a8391", "x": "#d1495b", "y": "#2e8b57", "z": "#30638e"}
"""Told apart by lightness too, for colour-blind eyes."""

STRIP = 0.62
"""Height of a sensor's row in a film, inches."""

UNITS = {"m/s2": "m/s²", "uT": "µT"}


@OWN_STYLE
def signal_figure(path: str | Path, recording: ImuRecording, title: str, subtitle: str) -> None:
    """Draw the first sensor of a recording to a PNG file."""
    readings = recording.readings
    height = 1.0 + 2.1 * len(readings)
    figure = Figure(figsize=(9, height), dpi=160, facecolor="white")
    FigureCanvasAgg(figure)
    rows = figure.subplots(len(readings), 1, sharex=True)
    bottom, top = 0.572 / height, 1 - 0.832 / height
    left = 0.09 if recording.barometer is None else 0.13  # six digits and a decimal
    figure.subplots_adjust(left=left, right=0.94, top=top, bottom=bottom, hspace=0.16)
    figure.text(left, 1 - 0.338 / height, title, fontsize=14, fontweight="bold", color=INK)
    figure.text(left, 1 - 0.582 / height, subtitle, fontsize=9.5, color=FAINT)
    for axes, reading in zip(rows, readings, strict=True):
        label = ", ".join(filter(None, (reading.title, UNITS.get(reading.unit, reading.unit))))
        _plot(axes, recording, reading, 0)
        if len(reading.channels) > 1:
            axes.axhline(0, color=HAIRLINE, linewidth=0.8, zorder=0)
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.0)
        axes.set_ylabel(label, color=INK)
    rows[-1].set_xlabel("Time, s", color=INK)
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png")


@OWN_STYLE
def moving_signals(recording: ImuRecording, pixels: int) -> Callable[[float], Image.Image]:
    """A function that draws the specific force of a recording's sensors, one below the other, at a time.

    The picture is so many `pixels` wide and goes below one of `heatmap.moving_figure`: badges number the
    sensors, a line across stands at the time, seconds.
    """
    n_rows, width, length = recording.n_sensors, pixels / DPI, max(float(recording.time[-1]), 1e-9)
    height = n_rows * STRIP + 2 * MARGIN
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    acc = recording.readings[0]
    limits = np.nanmin(recording.acc, initial=0.0), np.nanmax(recording.acc, initial=0.0)
    left, right = MARGIN + 0.5, width - MARGIN
    title = f"{recording.clip}: {acc.title.lower()}, {UNITS[acc.unit]}, over time, s"
    write(figure, left, height - 0.3, title, 9.5, FAINT)
    for row in range(n_rows):
        bottom = MARGIN + (n_rows - 1 - row) * STRIP
        corner = axes_at(figure, MARGIN, bottom, 0.3, STRIP)
        corner.set(xlim=(0, 0.3), ylim=(0, STRIP))
        draw_badge(corner, (0.1, STRIP / 2), row + 1)
        axes = axes_at(figure, left, bottom, right - left, STRIP - 0.12)
        axes.set_axis_on()
        _plot(axes, recording, acc, row)
        axes.set(xlim=(0, length), ylim=limits)
        axes.tick_params(labelbottom=row == n_rows - 1)
    canvas.draw()
    still = drawn_on(figure)

    def at(time: float) -> Image.Image:
        shown = still.copy()
        share = min(max(time / length, 0.0), 1.0)
        x, low, high = (left + share * (right - left)) * DPI, MARGIN * DPI, (height - MARGIN) * DPI
        ImageDraw.Draw(shown).line([x, low, x, high], INK, 3)
        return shown

    return at


def _plot(axes: Axes, recording: ImuRecording, reading: Reading, sensor: int) -> None:
    """Draw the channels of a sensor's reading over time."""
    values = getattr(recording, reading.name)[:, sensor]
    for channel, own in zip(reading.channels, values.T, strict=True):
        name = channel.rpartition("_")[2]
        axes.plot(recording.time, own, color=COLOURS.get(name, INK), linewidth=1.3, label=name)
    axes.margins(x=0)
    axes.tick_params(colors=FAINT, labelcolor=INK, labelsize=8.5)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(HAIRLINE)
