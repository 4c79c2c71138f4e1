# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a validation: F1 by site and activity, real next to simulated; confusions side by side."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from w2w.core.colours import colour_table
from w2w.core.files import atomic_write
from w2w.core.ranking.expected import WANTED
from w2w.drawing.page import ACCENT, DPI, FAINT, FONT, HAIRLINE, INK

from ..validation.sites import SiteValidation

rcParams["text.parse_math"] = False  # names are a user's words: one with two dollar signs is no formula

REAL, SIMULATED = INK, ACCENT
COLUMNS = 3
DARK = 0.6
"""Scores above this stand on a light colour and are written in ink."""


def score_maps_figure(path: str | Path, found: SiteValidation, title: str) -> None:
    """Two tables in colour: F1 of real and of simulated sensors, a row an activity, a column a site."""
    activities, sites = found.real.activities, found.sites
    height = 1.6 + 0.34 * (len(activities) + 1)
    figure = _figure(2.6 + 2 * (1.2 + 0.72 * len(sites)), height)
    axes = figure.subplots(1, 2, sharey=True)
    for ax, side, utility in zip(axes, ("Real", "Simulated"), (found.real, found.simulated), strict=True):
        table = np.concatenate([utility.f1, utility.mean[:, None]], axis=1).T
        image = ax.imshow(table, vmin=0, vmax=1, cmap=_colour_map(), aspect="auto")
        for row, column in np.ndindex(table.shape):
            colour = INK if table[row, column] > DARK else "white"
            ax.text(column, row, f"{table[row, column]:.2f}".removeprefix("0"), ha="center", va="center",
                    fontsize=8, color=colour)  # fmt: skip
        ax.axhline(len(activities) - 0.5, color="white", linewidth=3)
        ax.set_xticks(range(len(sites)), sites, rotation=30, ha="right", fontsize=8)
        ax.set_yticks(
            range(len(activities) + 1), [*(_words(name) for name in activities), "mean"], fontsize=8
        )
        ax.set_title(side, fontsize=10, color=INK)
        _bare(ax)
    figure.colorbar(image, ax=axes, label="F1", shrink=0.8)
    figure.suptitle(title, fontsize=12, color=INK)
    _save(figure, path)


def site_bars_figure(path: str | Path, found: SiteValidation, title: str) -> None:
    """One panel per activity: real and simulated F1 of each site with its interval, and their rho."""
    activities, sites = found.real.activities, found.sites
    rows = -(-(len(activities) + 1) // COLUMNS)
    figure = _figure(3.6 * COLUMNS, 0.9 + 2.2 * rows)
    axes = figure.subplots(rows, COLUMNS, sharey=True, sharex=True, squeeze=False).ravel()
    positions = np.arange(len(sites))
    for number, ax in enumerate(axes):
        if number > len(activities):
            ax.set_axis_off()
            continue
        mean = number == len(activities)
        agreement = found.overall if mean else found.by_activity[activities[number]]
        for offset, colour, label, utility in (
            (-0.2, REAL, "real", found.real),
            (0.2, SIMULATED, "simulated", found.simulated),
        ):
            score = utility.mean if mean else utility.f1[:, number]
            low, high = utility.mean_interval if mean else utility.f1_interval[:, :, number]
            ax.bar(positions + offset, score, 0.36, color=colour, label=label)
            ax.vlines(positions + offset, low, high, color=FAINT, linewidth=1.2)
        rho = "no ranking" if np.isnan(agreement.spearman) else f"ρ = {agreement.spearman:.2f}"
        name = "mean of all" if mean else _words(activities[number])
        ax.set_title(f"{name}: {rho}", fontsize=9, color=INK, fontweight="bold" if mean else "normal")
        ax.set_ylim(0, 1.02)
        ax.set_xticks(positions, sites, rotation=35, ha="right", fontsize=8)
        ax.tick_params(labelbottom=True)
        _bare(ax)
    axes[0].set_ylabel("F1")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2, frameon=False)
    figure.suptitle(title, fontsize=12, color=INK)
    _save(figure, path)


def cells_figure(path: str | Path, found: SiteValidation, title: str) -> None:
    """Simulated against real F1 of every site and activity, and of the means with their intervals."""
    import matplotlib

    figure = _figure(6.4, 5.2)
    ax = figure.subplots()
    ax.plot([0, 1], [0, 1], color=HAIRLINE, linewidth=1, zorder=0)
    colours = matplotlib.colormaps["tab10"].colors
    real, simulated = (side.mean_interval for side in (found.real, found.simulated))
    for number, site in enumerate(found.sites):
        colour = colours[number % len(colours)]
        ax.scatter(
            found.simulated.f1[number], found.real.f1[number], s=16, color=colour, alpha=0.45, linewidths=0
        )
        x, y = found.simulated.mean[number], found.real.mean[number]
        ax.hlines(y, *simulated[:, number], color=colour, linewidth=1)
        ax.vlines(x, *real[:, number], color=colour, linewidth=1)
        ax.scatter([x], [y], s=70, color=colour, label=site, edgecolors="white", zorder=3)
    ax.set_xlim(0, 1.02)
    ax.set_ylim(0, 1.02)
    ax.set_xlabel("F1, simulated sensors")
    ax.set_ylabel("F1, worn sensors")
    ax.set_title(
        f"means: ρ = {found.overall.spearman:.2f}; cells: r = {found.cells.value:.2f}", fontsize=9, color=INK
    )
    ax.legend(frameon=False, fontsize=8, loc="upper left", title="large: mean of all, 95 %", title_fontsize=8)
    _bare(ax)
    figure.suptitle(title, fontsize=12, color=INK)
    _save(figure, path)


def curve_figure(
    path: str | Path,
    clips: Sequence[int],
    mean: Sequence[float],
    by_activity: Sequence[float],
    f1: Sequence[float],
) -> None:
    """Agreement of halves, and F1, against the clips of an activity in each half."""
    figure = _figure(6.4, 4.0)
    ax = figure.subplots()
    ax.plot(clips, mean, "o-", color=ACCENT, label="ρ of halves, mean over activities")
    ax.plot(clips, by_activity, "o--", color=ACCENT, label="ρ of halves, by activity")
    ax.plot(clips, f1, "s-", color=INK, label="F1 that one half's choice gives the other")
    ax.axhline(WANTED, color=HAIRLINE, linewidth=1, zorder=0)
    ax.set_xticks(list(clips))
    ax.set_ylim(min(0.0, *mean, *by_activity), 1.02)
    ax.set_xlabel("clips of an activity in each half")
    ax.legend(frameon=False, fontsize=8)
    _bare(ax)
    _save(figure, path)


def confusions_figure(
    path: str | Path, confusions: Mapping[str, np.ndarray], activities: Sequence[str], title: str
) -> None:
    """Confusion matrices side by side: shares of actual activities (rows) by predicted ones (columns)."""
    size = 1.2 + 0.2 * len(activities)
    figure = _figure(1.6 + size * len(confusions), 2.7 + size)
    axes = figure.subplots(1, len(confusions), sharey=True, squeeze=False).ravel()
    for ax, (name, counts) in zip(axes, confusions.items(), strict=True):
        share = counts / np.maximum(1, counts.sum(axis=1, keepdims=True))
        image = ax.imshow(share, vmin=0, vmax=1, cmap=_colour_map())
        ax.set_xticks(range(len(activities)), activities, rotation=90, fontsize=7)
        ax.set_yticks(range(len(activities)), activities, fontsize=7)
        ax.set_title(name, fontsize=9, color=INK)
        _bare(ax)
    figure.colorbar(image, ax=axes, label="share of the true action", shrink=0.6)
    figure.suptitle(title, fontsize=12, color=INK)
    _save(figure, path)


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _bare(ax) -> None:
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color(HAIRLINE)
    ax.tick_params(length=0, colors=INK)


def _colour_map() -> ListedColormap:
    return ListedColormap(colour_table(steps=256))


def _words(name: str) -> str:
    return name.replace("_", " ")


def _save(figure: Figure, path: str | Path) -> None:
    for text in figure.findobj(lambda artist: hasattr(artist, "set_fontfamily")):
        text.set_fontfamily(FONT)
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png", dpi=DPI * 0.6, metadata={"Software": None})
