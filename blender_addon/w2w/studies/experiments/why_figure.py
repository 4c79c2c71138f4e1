# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture of `why_truth`: each step's rho by activity and its interval, a panel an analysis."""

from __future__ import annotations

import csv
from pathlib import Path

from matplotlib import rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from w2w.core.files import atomic_write
from w2w.drawing.page import ACCENT, DPI, FAINT, FONT, HAIRLINE, INK

rcParams["text.parse_math"] = False  # names are a user's words: one with two dollar signs is no formula

TITLES = {
    "utd_wrist": "UTD-MHAD's wrist, 21 activities",
    "mhad_all_actions": "Berkeley MHAD, all actions",
    "mhad_Kinect": "Berkeley MHAD, Kinect",
    "umafall_all_activities": "UMAFall",
    "dsads_all_activities": "DSADS",
}


def figure(out: Path) -> None:
    """Write ``why.png`` from the tables in a folder."""
    tables = {name: _rows(path) for name in TITLES if (path := out / f"why_{name}.csv").exists()}
    sets = {name: rows for name, rows in tables.items() if name != "utd_wrist"}
    if not sets:
        return
    steps = [row["step"] for row in next(iter(sets.values()))]
    picture = Figure(figsize=(3.2 + 2.3 * len(sets), 0.9 + 0.27 * len(steps)), dpi=DPI, layout="constrained")
    FigureCanvasAgg(picture)
    axes = picture.subplots(1, len(sets), sharey=True, squeeze=False)[0]
    lowest = min(float(row["by_activity_low"]) for rows in sets.values() for row in rows)
    for ax, (name, rows) in zip(axes, sets.items(), strict=True):
        for number, row in enumerate(rows):
            value, low, high = (float(row[f"by_activity{end}"]) for end in ("", "_low", "_high"))
            colour = ACCENT if "simulated" in row["step"].replace("simulated band", "") else INK
            ax.plot([low, high], [number, number], color=FAINT, linewidth=1.2, zorder=1)
            ax.plot([value], [number], "o", color=colour, markersize=5)
        ax.set_title(TITLES[name], fontsize=9, color=INK, fontname=FONT[0])
        ax.set_xlim(min(-0.4, lowest - 0.05), 1.0)
        ax.axvline(0, color=HAIRLINE, linewidth=1)
        ax.set_xlabel("mean rho by activity", fontsize=8, color=INK)
        ax.tick_params(labelsize=8, colors=INK, length=0)
        ax.set_yticks(range(len(steps)), steps)
        for side in ("top", "right", "left"):
            ax.spines[side].set_visible(False)
        ax.spines["bottom"].set_color(HAIRLINE)
    axes[0].set_ylim(len(steps) - 0.5, -0.5)
    with atomic_write(out / "why.png") as stream:
        picture.savefig(stream, format="png", metadata={"Software": None})


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))
