# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of a sweep: how far each case's ranking agrees, and which parts of the body gain and lose."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from w2w.core.files import atomic_write
from w2w.core.patches.body_parts import find_patches
from w2w.core.patches.patches import PatchSet
from w2w.drawing.page import ACCENT, DPI, FAINT, HAIRLINE, INK

from .report import SweptCase
from .sensitivity import resampled_clips

rcParams["text.parse_math"] = False  # names are a user's words: one with two dollar signs is no formula

ROW = 0.34
"""Height of a case, inches."""

BODY_PARTS = (
    "head", "neck", "chest", "back", "left arm", "right arm", "left hand", "right hand",
    "left leg", "right leg", "left foot", "right foot",
)  # fmt: skip
"""Columns; arms without their hands, legs without their feet."""


def sweep_figure(path: str | Path, swept: Sequence[SweptCase], patches: PatchSet) -> None:
    """Draw a sweep: rho with its interval by case, and mean F1 by part of the body and case.

    `path`: the PNG file to write.
    `swept`: the usual case first.
    """
    height = ROW * len(swept)
    page = (12.5, height + 2.35)
    figure = Figure(figsize=page, dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    figure.text(0.02, 1 - 0.42 / page[1], "Where the ranking holds", fontsize=16, weight="bold", color=INK)
    usual = swept[0]
    figure.text(
        0.02,
        1 - 0.72 / page[1],
        f"Macro F1 at {len(patches)} patches; {usual.utility.protocol}, {usual.utility.classifier}",
        fontsize=9.5,
        color=FAINT,
    )
    bottom, share = 0.55 / page[1], height / page[1]
    _draw_agreement(figure.add_axes((0.19, bottom, 0.27, share)), swept)
    _draw_parts(figure.add_axes((0.52, bottom, 0.46, share)), swept, patches)
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})


def _draw_agreement(axes: Axes, swept: Sequence[SweptCase]) -> None:
    rows = np.arange(len(swept))
    low, high = resampled_clips(swept[0].utility)
    axes.axvspan(low, high, color=HAIRLINE, alpha=0.6, linewidth=0)
    for row, one in zip(rows[1:], swept[1:], strict=True):
        axes.plot([one.shift.low, one.shift.high], [row, row], color=ACCENT, linewidth=2)
        axes.plot(one.shift.rho, row, "o", color=ACCENT, markersize=5)
    axes.set_yticks(rows, [one.case.title for one in swept])
    axes.set_ylim(len(swept) - 0.5, -0.5)
    axes.set_xlim(min(0.0, low, *(one.shift.low for one in swept)) - 0.03, 1.03)
    axes.set_title("Spearman's rho with the usual ranking", fontsize=10, color=INK, loc="left", pad=34)
    axes.set_xlabel("grey: the same clips resampled, nothing changed", fontsize=8.5, color=FAINT)
    axes.tick_params(length=0, labelsize=9, labelcolor=INK)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(HAIRLINE)


def _draw_parts(axes: Axes, swept: Sequence[SweptCase], patches: PatchSet) -> None:
    """Mean F1 of each part; the colour is its distance from the mean over the body in the same case."""
    parts = {name: found for name in BODY_PARTS if len(found := _patches_of(name, patches))}
    scores = np.array([[one.utility.mean[p].mean() for p in parts.values()] for one in swept])
    apart = scores - np.array([one.utility.mean.mean() for one in swept])[:, None]
    reach = max(np.abs(apart).max(), 1e-3)
    axes.imshow(apart, aspect="auto", cmap="PuOr_r", vmin=-reach, vmax=reach)
    for (row, column), score in np.ndenumerate(scores):
        dark = abs(apart[row, column]) > 0.6 * reach
        axes.text(
            column, row, f"{score:.2f}".removeprefix("0"), ha="center", va="center", fontsize=8.5,
            color="white" if dark else INK,
        )  # fmt: skip
    axes.set_xticks(range(len(parts)), [name.replace(" ", "\n") for name in parts])
    axes.set_yticks([])
    axes.xaxis.tick_top()
    axes.tick_params(length=0, labelsize=8.5, labelcolor=INK)
    axes.set_title("Mean F1 of a part's patches", fontsize=10, color=INK, loc="left", pad=10)
    axes.set_xlabel("orange above, violet below the body's mean in that case", fontsize=8.5, color=FAINT)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _patches_of(part: str, patches: PatchSet) -> np.ndarray:
    found = find_patches(patches.regions, patches.names, part)
    side, _, limb = part.rpartition(" ")
    end = {"arm": "hand", "leg": "foot"}.get(limb)
    if end is None:
        return found
    return np.setdiff1d(found, find_patches(patches.regions, patches.names, f"{side} {end}".strip()))
