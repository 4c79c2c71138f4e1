# SPDX-License-Identifier: GPL-3.0-or-later
"""Options for windows: their length, their stride, and a warning when clips are too short for them."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

from w2w.core.ranking.windows import WindowSpec
from w2w.core.study import RANKING

Stride = Annotated[
    float | None,
    typer.Option(
        min=0.05,
        help="Stride of the training windows, seconds.  [default: half the window]",
        show_default=False,
        rich_help_panel=RANKING,
    ),
]


def window_spec(window: float, stride: float | None) -> WindowSpec:
    """The options as `WindowSpec`.

    Raises
    ------
    ValueError
        If they cannot be; the message names the options.
    """
    if not math.isfinite(window):
        raise ValueError(f"--window must be a number of seconds, not {window:g}")
    if stride is not None and not 0 < stride <= window:
        raise ValueError(
            f"--stride must be at most the window's length (--window {window:g}), not {stride:g}"
        )
    return WindowSpec.of_length(window, stride)


def window_warning(content: dict[str, Any], used: int) -> str:
    """A sentence where most clips are shorter than a window; empty where they are not."""
    shorter = content["clips_shorter"]
    if 2 * shorter <= used:
        return ""
    return (
        f"{shorter} of {used} clips are shorter than the window of {content['length_s']:g} s and are "
        f"repeated to fill it. Half of the clips last {content['longest_useful_s']:g} s or more: use a "
        "--window of at most that"
    )
