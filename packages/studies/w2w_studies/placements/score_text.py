# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of placements, on the console and as csv."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from w2w.core.csv_tables import apart, csv_text
from w2w.core.files import DIGITS, write_text
from w2w.core.findings.notes import interval_text
from w2w.core.patches.naming import Nearest
from w2w.core.ranking.costs import is_as_good
from w2w.core.ranking.f1 import FEWEST_CLIPS
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.headline import doubt, mean_caution

from .score_table import ScoreRow


def show_placements(
    utility: UtilityMap, placements: Mapping[str, Nearest], title: str, console: Console
) -> None:
    """Print placements by the F1 expected of the patch nearest to each, the best first."""
    table = Table(title=title, title_justify="left")
    table.add_column("placement")
    headings = ("expected F1", "95 % interval", "as well as the best", "on these clips", "patch away")
    for heading in headings:
        table.add_column(heading, justify="right")
    if doubted := doubt(utility):
        console.print(f"{doubted}.", style="bold yellow")
    best = utility.expected_mean.max()
    best_first = sorted(placements.items(), key=lambda item: -utility.expected_mean[item[1].patch])
    for name, (patch, away_m) in best_first:
        low, high = utility.expected_low[patch], utility.expected_high[patch]
        table.add_row(
            name,
            f"{utility.expected_mean[patch]:.2f}",
            interval_text(low, high, mean_caution(utility), 2),
            "yes" if is_as_good(best - utility.expected_mean[patch]) else "no",
            f"{utility.mean[patch]:.2f}",
            f"{100 * away_m:.1f} cm",
        )
    console.print(table)


def show_scores(rows: Sequence[ScoreRow], columns: Sequence[str], title: str, console: Console) -> None:
    """Print a table a group: F1 over its interval; bold where it cannot be told from the row's best."""
    for group, members in groupby(rows[:-1], key=lambda row: row.group):
        name = _words(group) or title
        console.print(_table(list(members), columns, name))
    overall = _table([rows[-1]], columns, "All activities")
    console.print(overall)
    console.print(
        "F1 on these clips with its 95 % interval below, by a bootstrap over clips. Bold: cannot be told "
        f"apart from the best of the row. 'n': clips tested; 'few clips': under {FEWEST_CLIPS}, too few "
        "for an interval.",
        style="dim",
    )


MEAN, EXPECTED_MEAN = "mean", "expected mean"
"""What stands in the column of activities where a line is of a mean over them."""


def write_scores(
    path: Path, rows: Sequence[ScoreRow], columns: Sequence[str], patches: Sequence[int], utility: UtilityMap
) -> None:
    """Write one line per cell: group, activity, placement, patch, F1, its interval, motions and windows.

    The last lines, "expected mean", are what other clips would show; in these lines `same_as_best` compares
    with the best patch of all.
    """
    names = [row.activity for row in rows if row.activity]
    name_of = {"": MEAN, **dict(zip(names, apart(names, (MEAN, EXPECTED_MEAN)), strict=True))}
    lines = [
        ["group", "activity", "placement", "patch", "f1", "low", "high", "same_as_best", "motions", "windows"]
    ]
    for row in rows:
        head = (row.group or "all", name_of[row.activity])
        for number, (column, patch) in enumerate(zip(columns, patches, strict=True)):
            scores = (f"{values[number]:.{DIGITS}f}" for values in (row.f1, row.low, row.high))
            same = "yes" if row.best[number] else "no"
            lines.append([*head, column, patch, *scores, same, row.clips, row.windows])
    best = utility.expected_mean.max()
    for column, patch in zip(columns, patches, strict=True):
        cells = [f"{values[patch]:.{DIGITS}f}" for values in utility.expected]
        equal = "yes" if is_as_good(best - utility.expected_mean[patch]) else "no"
        tested = (len(np.unique(utility.clip)), len(utility.truth))
        lines.append(["all", EXPECTED_MEAN, column, patch, *cells, equal, *tested])
    write_text(path, csv_text(lines))


def _table(rows: Sequence[ScoreRow], columns: Sequence[str], title: str) -> Table:
    table = Table(title=title, title_justify="left")
    table.add_column("activity", overflow="fold")
    table.add_column("n", justify="right")
    for column in columns:
        table.add_column(column, justify="right", overflow="fold", min_width=7)
    for row in rows:
        cells = [_cell(row, number) for number in range(len(columns))]
        table.add_row(_words(row.activity) or "mean", str(row.clips), *cells)
    return table


def _cell(row: ScoreRow, number: int) -> Text:
    best = row.best[number] and row.f1.any()
    score = f"{row.f1[number]:.2f}", "bold" if best else ""
    few = row.activity and row.clips < FEWEST_CLIPS
    interval = "few clips" if few else f"{_short(row.low[number])}-{_short(row.high[number])}"
    return Text.assemble(score, (f"\n{interval}", "dim"))


def _short(value: float) -> str:
    """Two decimals without the leading nought."""
    text = f"{value:.2f}"
    return text.removeprefix("0") if value < 0.995 else "1"


def _words(name: str) -> str:
    return name.replace("_", " ")
