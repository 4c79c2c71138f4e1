# SPDX-License-Identifier: GPL-3.0-or-later
"""Claims about parts of the body and what a ranking says of them: on the screen, as csv and as markdown."""

from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from w2w.core.csv_tables import csv_text

from .trends import LEVEL, Trend

HEADINGS = ("claim", "group", "regions", "against", "difference of F1", "interval", "clips", "verdict")

EXPLAINED = (
    f"Difference: mean F1 over the group's activities at the patches of the regions, less that at those held "
    f"against them. The intervals hold at {100 * LEVEL:g} % for all claims together; where one holds 0, or "
    "the group has too few clips for one, the claim is undecided."
)


def show_trends(trends: Sequence[Trend], console: Console) -> None:
    """Print what the ranking says of each claim."""
    table = Table(title="Claims about parts of the body", title_justify="left")
    for heading in HEADINGS:
        right = heading in ("difference of F1", "interval", "clips")
        table.add_column(heading, justify="right" if right else "left", overflow="fold")
    for trend in trends:
        table.add_row(*_cells(trend))
    console.print(table)
    console.print(EXPLAINED, style="dim")


def trend_csv(trends: Sequence[Trend]) -> str:
    """One line a claim."""
    names = ("f1", "other_f1", "difference", "low", "high")
    lines = [["claim", "group", "regions", "against", *names, "activities", "clips", "verdict"]]
    for trend in trends:
        claim = trend.claim
        numbers = (getattr(trend, name) for name in names)
        scores = ["" if np.isnan(number) else f"{number:.6f}" for number in numbers]
        head = [claim.text, claim.group or "all", "; ".join(claim.regions), "; ".join(claim.against)]
        lines.append([*head, *scores, trend.activities, trend.clips, trend.verdict])
    return csv_text(lines)


def trend_markdown(trends: Sequence[Trend]) -> str:
    """The table and how to read it."""
    rows = [HEADINGS, ["---"] * len(HEADINGS), *map(_cells, trends)]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join([*lines, "", EXPLAINED, ""])


def _cells(trend: Trend) -> list[str]:
    claim = trend.claim
    missing = bool(trend.why)
    return [
        claim.text,
        claim.group.replace("_", " ") or "all",
        ", ".join(claim.regions),
        ", ".join(claim.against) or "the rest of the body",
        "" if missing else f"{trend.difference:+.2f}",
        trend.why if missing else f"{trend.low:+.2f} to {trend.high:+.2f}",
        str(trend.clips),
        trend.verdict,
    ]
