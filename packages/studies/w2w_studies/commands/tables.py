# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w tables`: F1 of every activity at the 11 placements, in groups, from a finished ranking."""

from collections import Counter
from collections.abc import Iterable
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from w2w.core.csv_tables import read_table
from w2w.core.library.labels import by_label
from w2w.core.study.results import StudyResults
from w2w.headless.console import USAGE, ending, show_left_out
from w2w.headless.runs.own_files import check, claimed, new_file

from ..placements.placement_patches import placement_patches
from ..placements.score_table import score_table
from ..placements.score_text import show_placements, show_scores, write_scores
from .consoles import show_caution, wide_console

TABLES = "tables.csv"


def tables(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    groups: Annotated[
        Path | None,
        typer.Option(help="csv with columns activity, group: a table a group. Else one table of all."),
    ] = None,
    side: Annotated[
        str, typer.Option(help="Side of the placements that exist on both: left or right.")
    ] = "left",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="csv file.  [default: tables.csv in RESULTS]", show_default=False),
    ] = None,
) -> None:
    """Print the expected F1 of the paper's 11 placements and their F1 by activity, and save them as csv.

    Exit codes: 0 printed, 2 wrong use.
    """
    console = wide_console()
    with ending(USAGE, console):
        study = StudyResults.load(results)
        group_of = read_groups(groups, study.utility.activities) if groups else {}
        if side not in ("left", "right"):
            raise ValueError(f"--side is left or right, not {side}")
        if out is None:
            check(results, [TABLES])
        new_file(out)
        placements = placement_patches(
            study.body(), study.patches, side, lambda text: show_caution(text, console)
        )
    patches = [found.patch for found in placements.values()]
    rows = score_table(study.utility, patches, group_of)
    show_placements(study.utility, placements, f"Placements, {side} side, all activities", console)
    show_scores(rows, list(placements), f"F1 at the placements, {side} side", console)
    show_left_out(study.utility.left_out, console)
    path = out or results / TABLES
    with nullcontext() if out else claimed(results, [TABLES]):
        write_scores(path, rows, list(placements), patches, study.utility)
    console.print(f"{study.utility.protocol}, {study.utility.classifier}. Table: {path}")


def read_groups(path: Path, activities: Iterable[str]) -> dict[str, str]:
    """Groups of activities that have one: for each, the group that most lines of the csv give it.

    Raises ValueError if the file cannot be read or lacks the columns ``activity`` and ``group``.
    """
    lines: dict[str, Counter[str]] = {}
    for _, row in read_table(path, ("activity", "group")).rows:
        if row["activity"] and row["group"]:
            lines.setdefault(row["activity"], Counter())[row["group"]] += 1
    return by_label({name: groups.most_common(1)[0][0] for name, groups in lines.items()}, activities)
