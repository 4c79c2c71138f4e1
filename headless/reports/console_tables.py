# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says on the console: the labels it understood, what it skipped, what it found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from w2w.core.findings.best_regions import best_regions
from w2w.core.findings.counts import counts_sentence, interval_text
from w2w.core.findings.finished_study import ClipResult, Study
from w2w.core.findings.label_notes import copies_sentence, label_notes
from w2w.core.findings.own_placements import own_content
from w2w.core.findings.sources import shown_in, source_caution
from w2w.core.findings.summary import study_counts, window_content
from w2w.core.garments.findings import caught_sentences, garment_content, garment_sentence
from w2w.core.motion.library import Library
from w2w.core.ranking.windows import WindowSpec
from w2w.core.results_folder import StudyResults
from w2w.core.selection.headline import mean_caution

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
    advice_text.show_worn(study.advice, study.results.patches, console)
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
