# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of one sensor's signal: specific force above, angular velocity below."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from w2w.core.files import atomic_write
from w2w.core.imu.recording import ImuRecording

COLOURS = ("#d1495b", "#2e8b57", "#30638e")
"""x, y, z: told apart by lightness too, for colour-blind eyes."""

INK, FAINT, HAIRLINE = "#1d2530", "#7a8391", "#d9dde3"


def signal_figure(
    path: str | Path, recording: ImuRecording, title: str, subtitle: str = "", sensor: int = 0
) -> None:
    """Draw one sensor of a recording.

    Parameters
    ----------
    path : str or Path
        The PNG file to write.
    recording : ImuRecording
    title, subtitle : str
    sensor : int
        Which of the recording's sensors.
    """
    figure = Figure(figsize=(9, 5.2), dpi=160, facecolor="white")
    FigureCanvasAgg(figure)
    upper, lower = figure.subplots(2, 1, sharex=True)
    figure.subplots_adjust(left=0.09, right=0.94, top=0.84, bottom=0.11, hspace=0.16)
    figure.text(0.09, 0.935, title, fontsize=14, fontweight="bold", color=INK)
    figure.text(0.09, 0.888, subtitle, fontsize=9.5, color=FAINT)
    _draw(upper, recording.time, recording.acc[:, sensor], "Specific force, m/s²")
    _draw(lower, recording.time, recording.gyr[:, sensor], "Angular velocity, rad/s")
    lower.set_xlabel("Time, s", color=INK)
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png")


def _draw(axes: Axes, time: np.ndarray, values: np.ndarray, label: str) -> None:
    for column, (name, colour) in enumerate(zip("xyz", COLOURS, strict=True)):
        axes.plot(time, values[:, column], color=colour, linewidth=1.3, label=name)
    axes.axhline(0, color=HAIRLINE, linewidth=0.8, zorder=0)
    axes.set_ylabel(label, color=INK)
    axes.margins(x=0)
    axes.tick_params(colors=FAINT, labelcolor=INK, labelsize=8.5)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.0)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(HAIRLINE)
