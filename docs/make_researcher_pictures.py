# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of docs/researcher.md from the results of a study, the demo's by default.

make demo && .venv/bin/python docs/make_researcher_pictures.py [RESULTS]
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from w2w.core.ranking.utility import UtilityMap

PROJECT = Path(__file__).resolve().parents[1]
RESULTS = PROJECT / "demo_output" / "results"
PICTURES = PROJECT / "docs" / "pictures"
BLUE, ORANGE, GREY = "#1f4e9e", "#d9730d", "#b9c0cc"


def draw_ranking(utility: UtilityMap) -> None:
    """All patches by mean F1 with their intervals; those that cannot be told from the best one stand out."""
    order = np.argsort(-utility.mean, kind="stable")
    same = np.array([utility.same([int(order[0])], [int(patch)]) for patch in order])
    rank = np.arange(1, len(order) + 1)
    figure, axes = plt.subplots(figsize=(8, 3.6), layout="constrained")
    for chosen, colour, label in (
        (same, ORANGE, f"cannot be told from the best: {same.sum()} patches"),
        (~same, GREY, f"worse than the best: {(~same).sum()} patches"),
    ):
        axes.vlines(
            rank[chosen],
            utility.mean_low[order][chosen],
            utility.mean_high[order][chosen],
            colors=colour,
            linewidth=1,
            label=label,
        )
    axes.plot(rank, utility.mean[order], color=BLUE, linewidth=1.8, label="mean F1")
    axes.set_xlabel("patch, by rank")
    axes.set_ylabel(f"mean F1, {utility.level:.0%} interval")
    axes.set_xlim(0, len(order) + 1)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower left")
    save(figure, "researcher_ranking")


def draw_confusion(utility: UtilityMap) -> None:
    """What the best and the worst patch take activities for."""
    chosen = (("best", int(utility.mean.argmax())), ("worst", int(utility.mean.argmin())))
    figure, grid = plt.subplots(1, 2, figsize=(8, 3.7), sharey=True, layout="constrained")
    names = [name.replace("_", " ") for name in utility.activities]
    for axes, (title, patch) in zip(grid, chosen, strict=True):
        counts = utility.confusion[patch]
        axes.imshow(counts / counts.sum(axis=1, keepdims=True), cmap="Blues", vmin=0, vmax=1)
        for (row, column), count in np.ndenumerate(counts):
            dark = count > 0.6 * counts[row].sum()
            axes.text(column, row, count, ha="center", va="center", color="white" if dark else "black")
        axes.set_title(f"{title} patch: mean F1 {utility.mean[patch]:.2f}")
        axes.set_xticks(range(len(names)), names, rotation=25, ha="right")
        axes.set_yticks(range(len(names)), names)
        axes.set_xlabel("named")
    grid[0].set_ylabel("true activity, windows")
    save(figure, "researcher_confusion")


def save(figure: plt.Figure, name: str) -> None:
    """Write a picture without anything that changes from run to run."""
    figure.savefig(PICTURES / f"{name}.png", dpi=120, metadata={"Software": None})
    plt.close(figure)


def main(results: Path = RESULTS) -> None:
    """Draw all."""
    utility = UtilityMap.load(results / "utility.npz")
    draw_ranking(utility)
    draw_confusion(utility)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
