# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says on the console: the labels it understood, what it skipped, what it found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from w2w.core.csv_tables import csv_text
from w2w.core.files import DIGITS, write_text
from w2w.core.findings.best_regions import best_regions
from w2w.core.findings.counts import counts_sentence, interval_text
from w2w.core.findings.finished_study import ClipResult, Study
from w2w.core.findings.garments import caught_sentences, garment_content, garment_sentence
from w2w.core.findings.label_notes import copies_sentence, label_notes
from w2w.core.findings.own_placements import own_content
from w2w.core.findings.sources import shown_in, source_caution
from w2w.core.findings.summary import study_counts, window_content
from w2w.core.motion.library import Library
from w2w.core.ranking.f1 import FEWEST_CLIPS
from w2w.core.ranking.score_table import ScoreRow
from w2w.core.ranking.utility import UtilityMap
from w2w.core.ranking.windows import WindowSpec
from w2w.core.results_folder import StudyResults
from w2w.core.selection.headline import CANNOT_RANK, mean_caution

from ..console import show_left_out
from ..runs.picture_names import HEATMAPS
from ..runs.study import RunPlan
from ..window_options import window_warning
from . import advice_text, html, own_table, pictures


def show_labels(library: Library, console: Console) -> None:
    """Print the labelling that was understood."""
    table = Table(
        title=f"{len(library.clips)} clips, labelled by {library.labelled_by}", title_justify="left"
    )
    table.add_column("activity")
    table.add_column("clips", justify="right")
    table.add_column("for example")
    for activity, count in library.activities.items():
        example = next(clip.file for clip in library.clips if clip.activity == activity)
        table.add_row(escape(activity), str(count), escape(example))
    console.print(table)
    for note in label_notes(library.check):
        console.print(f"Labels: {note}", style="yellow", markup=False)


def show_outcome(study: Study, plan: RunPlan, failed: Mapping[str, str], console: Console) -> None:
    """Print what was found and where it stands, and what could not be drawn."""
    out, utility = study.results.out, study.results.utility
    skipped = skipped_files(study.clips, study.library)
    show_skipped(skipped, console)
    show_left_out(utility.left_out, console)
    show_copies(study.copies, console)
    show_window_warning(study.clips, study.config.windows, console)
    if caution := source_caution(shown_in(study)):
        console.print(f"Caution: {caution}.", style="bold yellow", markup=False)
    _show_garments(study, console)
    advice_text.show_best_spot(study.advice, utility, study.results.patches, console)
    _show_regions(study.results, console)
    own_table.show_own_placements(own_content(study), console)
    if study.worn is not None:
        advice_text.show_worn(study.worn, study.results.patches, console)
    advice_text.show_advice(study.advice, utility, study.results.patches, study.together, console)
    console.print(f"{counts_sentence(study_counts(study), utility)}.")
    console.print(f"\nTable:    {out / 'utility.csv'}\nSummary:  {out / 'summary.json'}")
    if plan.pictures:
        for title, name in (("Heatmaps:", HEATMAPS), ("Blender: ", pictures.BLEND)):
            if name not in failed:
                console.print(f"{title} {out / name}")
    if plan.report:
        console.print(f"Report:   {out / html.REPORT}")
    for name, why in failed.items():
        console.print(f"\nNo {name}: {why}.", style="red", markup=False)
    if failed:
        console.print("Everything else is there; the same command goes on from here.")


def show_copies(copies: Sequence[tuple[str, str]], console: Console) -> None:
    """Say which clips count as copies of another."""
    if sentence := copies_sentence(copies):
        console.print(f"{sentence}.", style="yellow", markup=False)


def _show_garments(study: Study, console: Console) -> None:
    """Say which patches were on cloth, where any was."""
    patches = study.results.patches
    content = garment_content(study.results.out, study.config.garments, patches)
    if sentence := garment_sentence(content, len(patches)):
        console.print(f"{sentence}.", style="yellow", markup=False)
    for sentence in caught_sentences([(result.clip.name, result.details) for result in study.used]):
        console.print(f"{sentence}.", style="bold yellow", markup=False)


def show_window_warning(results: Sequence[ClipResult], spec: WindowSpec, console: Console) -> None:
    """Say so where most clips are shorter than a window."""
    used = sum(result.used for result in results)
    if warning := window_warning(window_content(results, spec), used):
        console.print(f"{warning}.", style="yellow", markup=False)


def _show_regions(results: StudyResults, console: Console) -> None:
    table = Table(title="Best regions (each by its best patch, mean over activities)", title_justify="left")
    table.add_column("patch")
    for heading in ("expected F1", "95 % interval", "as good as the best", "on these clips"):
        table.add_column(heading, justify="right")
    utility = results.utility
    for row in best_regions(utility, results.patches):
        interval = interval_text(row["low"], row["high"], mean_caution(utility))
        equal = "yes" if row["as_good"] else "no"
        table.add_row(row["name"], f"{row['expected']:.3f}", interval, equal, f"{row['f1']:.3f}")
    console.print(table)


def show_skipped(skipped: list[tuple[str, str]], console: Console) -> None:
    """Print which files were skipped, and why."""
    if not skipped:
        return
    table = Table(title=f"{len(skipped)} clips skipped", title_justify="left")
    table.add_column("file", overflow="fold")
    table.add_column("why", overflow="fold")
    for row in skipped:
        table.add_row(*map(escape, row))
    console.print(table)


def skipped_files(results: Sequence[ClipResult], library: Library) -> list[tuple[str, str]]:
    """Files without use and the reasons."""
    return [(result.clip.file, result.reason) for result in results if not result.used] + list(
        library.skipped
    )


def show_comparison(comparison: dict[str, Any], console: Console) -> None:
    """Print how far the maps of several bodies agree."""
    table = Table(
        title="How far the maps agree (Spearman's rho of mean F1 over patches)", title_justify="left"
    )
    table.add_column("bodies")
    table.add_column("rho", justify="right")
    table.add_column("95 % interval", justify="right")
    for pair in comparison["agreement"]:
        low, high = pair["interval"]
        table.add_row(" and ".join(pair["bodies"]), f"{pair['spearman_mean']}", f"{low} to {high}")
    console.print(table)


WIDTH = 140
"""Columns of a screen that is no terminal."""


def wide_console() -> Console:
    """A console on which the table is not squeezed when it is written to a file."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=WIDTH)


def show_placements(utility: UtilityMap, placements: Mapping[str, int], title: str, console: Console) -> None:
    """Print placements by the F1 expected of each, the best first."""
    table = Table(title=title, title_justify="left")
    table.add_column("placement")
    for heading in ("expected F1", "95 % interval", "as good as the best patch", "on these clips"):
        table.add_column(heading, justify="right")
    if not utility.can_rank:
        console.print(f"{CANNOT_RANK}.", style="bold yellow")
    for name, patch in sorted(placements.items(), key=lambda item: -utility.expected_mean[item[1]]):
        low, high = utility.expected_low[patch], utility.expected_high[patch]
        table.add_row(
            name,
            f"{utility.expected_mean[patch]:.2f}",
            interval_text(low, high, mean_caution(utility), 2),
            "yes" if utility.as_good[patch] else "no",
            f"{utility.mean[patch]:.2f}",
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


def write_scores(
    path: Path,
    rows: Sequence[ScoreRow],
    columns: Sequence[str],
    patches: Sequence[int],
    utility: UtilityMap | None = None,
) -> None:
    """Write one line a cell: group, activity, placement, patch, F1, its interval, motions and windows.

    With a map, the last lines, "expected mean", are what other clips would show; of them
    `same_as_best` means the best patch of all.
    """
    lines = [
        ["group", "activity", "placement", "patch", "f1", "low", "high", "same_as_best", "motions", "windows"]
    ]
    for row in rows:
        head = (row.group or "all", row.activity or "mean")
        for number, (column, patch) in enumerate(zip(columns, patches, strict=True)):
            scores = (f"{values[number]:.{DIGITS}f}" for values in (row.f1, row.low, row.high))
            same = "yes" if row.best[number] else "no"
            lines.append([*head, column, patch, *scores, same, row.clips, row.windows])
    for column, patch in zip(columns, patches, strict=True) if utility is not None else ():
        scores = (utility.expected_mean, utility.expected_low, utility.expected_high)
        cells = [f"{values[patch]:.{DIGITS}f}" for values in scores]
        equal = "yes" if utility.as_good[patch] else "no"
        tested = (len(np.unique(utility.clip)), len(utility.truth))
        lines.append(["all", "expected mean", column, patch, *cells, equal, *tested])
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
