# SPDX-License-Identifier: GPL-3.0-or-later
"""A table of F1 on the screen and as a csv file."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from rich.console import Console
from rich.table import Table

from blender_addon.w2w.core.csv_tables import csv_text
from blender_addon.w2w.core.files import write_text
from blender_addon.w2w.core.intervals import FEWEST_CLIPS
from blender_addon.w2w.core.score_table import ScoreRow

DIGITS = 6
WIDTH = 140
"""Columns of a screen that is no terminal."""


def wide_console() -> Console:
    """A console on which the table is not squeezed when it is written to a file."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=WIDTH)


def show_scores(rows: Sequence[ScoreRow], columns: Sequence[str], title: str, console: Console) -> None:
    """Print a table a group: F1 over its interval; bold where it cannot be told from the row's best."""
    for group, members in groupby(rows[:-1], key=lambda row: row.group):
        name = _words(group) or title
        console.print(_table(list(members), columns, name))
    overall = _table([rows[-1]], columns, "All activities")
    console.print(overall)
    console.print(
        "F1 with its 95 % interval below, by a bootstrap over clips. Bold: cannot be told apart from the "
        f"best of the row. 'n': clips tested; 'few clips': under {FEWEST_CLIPS}, too few for an interval.",
        style="dim",
    )


def write_scores(path: Path, rows: Sequence[ScoreRow], columns: Sequence[str], places: Sequence[int]) -> None:
    """Write one line a cell: group, activity, place, patch, F1, its interval, motions and windows."""
    lines = [
        ["group", "activity", "placement", "patch", "f1", "low", "high", "same_as_best", "motions", "windows"]
    ]
    for row in rows:
        head = (row.group or "all", row.activity or "mean")
        for number, (column, place) in enumerate(zip(columns, places, strict=True)):
            scores = (f"{values[number]:.{DIGITS}f}" for values in (row.f1, row.low, row.high))
            same = "yes" if row.best[number] else "no"
            lines.append([*head, column, place, *scores, same, row.clips, row.windows])
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


def _cell(row: ScoreRow, number: int) -> str:
    score = f"{row.f1[number]:.2f}"
    score = f"[bold]{score}[/bold]" if row.best[number] and row.f1.any() else score
    few = row.activity and row.clips < FEWEST_CLIPS
    interval = "few clips" if few else f"{_short(row.low[number])}-{_short(row.high[number])}"
    return f"{score}\n[dim]{interval}[/dim]"


def _short(value: float) -> str:
    """Two decimals without the leading nought."""
    text = f"{value:.2f}"
    return text.removeprefix("0") if value < 0.995 else "1"


def _words(name: str) -> str:
    return name.replace("_", " ")
