# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of one sensor's signal: specific force, angular velocity and the other readings."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..core.files import atomic_write
from ..core.imu.recording import ImuRecording
from .page import FAINT, HAIRLINE, INK, OWN_STYLE

COLOURS = {"w": "#7a8391", "x": "#d1495b", "y": "#2e8b57", "z": "#30638e"}
"""Told apart by lightness too, for colour-blind eyes."""

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
        values = getattr(recording, reading.name)[:, 0]
        for channel, own in zip(reading.channels, values.T, strict=True):
            name = channel.rpartition("_")[2]
            axes.plot(recording.time, own, color=COLOURS.get(name, INK), linewidth=1.3, label=name)
        if len(reading.channels) > 1:
            axes.axhline(0, color=HAIRLINE, linewidth=0.8, zorder=0)
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.0)
        axes.set_ylabel(label, color=INK)
        axes.margins(x=0)
        axes.tick_params(colors=FAINT, labelcolor=INK, labelsize=8.5)
        axes.ticklabel_format(axis="y", useOffset=False)
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set_color(HAIRLINE)
    rows[-1].set_xlabel("Time, s", color=INK)
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png")
