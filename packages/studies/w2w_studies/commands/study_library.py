# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study library`: a library of several sources, ranked within each of them."""

from pathlib import Path
from typing import Annotated

import typer

from w2w.core.library.library import Library, read_library
from w2w.core.study.results import StudyResults
from w2w.headless.commands.execute import ended, execute_bodies, ready_for, refused
from w2w.headless.console import NOTHING_TO_DO
from w2w.headless.options import with_options
from w2w.headless.reports.console_tables import show_labels
from w2w.headless.runs.own_files import claimed, keep_apart
from w2w.headless.runs.study import RunPlan
from w2w.headless.study_options import StudyOptions

from ..comparisons.library import LABELS, labelled_by_name, study_library, with_enough, write_labels
from ..comparisons.library_report import PAGE, WRITTEN, write_library
from .consoles import wide_console

ADDED = (LABELS, *WRITTEN)


@with_options(StudyOptions)
def library(
    libraries: Annotated[
        list[Path],
        typer.Argument(
            metavar="LIBRARY...",
            help="Folders of HDM05, Bandai-Namco, Mixamo, CMU or AMASS motions under their own file names; "
            "with --labels one folder of any.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; made if missing.")],
    labels: Annotated[
        Path | None,
        typer.Option(
            help="csv with columns file, activity, source[, subject].  [default: by the names of the files]",
            show_default=False,
        ),
    ] = None,
    fewest: Annotated[int, typer.Option(min=2, help="Activities that fewer clips show are left out.")] = 10,
    halvings: Annotated[
        int, typer.Option(min=1, help="Ways to halve the performers, to see how far maps agree.")
    ] = 4,
    *,
    asked: StudyOptions,
) -> None:
    """Rank a library of several sources within each source, and see how far its map repeats.

    Simulated sensors recognise the recording system of a clip, so an activity is compared with clips of its
    own source alone, performers left out. OUT then holds `library.md`, `library.csv`, `library.json`,
    `library_curve.png` and `labels.csv`, besides all that `w2w run` writes; it takes every option of
    `w2w run`.

    Exit codes: as `w2w run`.
    """
    console = wide_console()
    monitor = asked.monitor(console)
    with refused(monitor):
        config = asked.config()
        for folder in libraries:
            keep_apart(folder, out)
        found = with_enough(_read(libraries, labels, asked.exact_labels), fewest)
        plan = RunPlan(found, config, asked.engine(), asked.pictures, asked.report, ADDED)
        bodies = ready_for(plan, asked, out)
    show_labels(found, console)
    for _, study in execute_bodies(plan, bodies, out, asked.strict, monitor):
        folder = study.results.out
        with claimed(folder, ADDED):
            write_labels(folder / LABELS, found)
            try:
                findings = study_library(StudyResults.load(folder), halvings, monitor.step)
            except ValueError as error:
                raise ended(f"The sources cannot be compared: {error}", NOTHING_TO_DO, monitor) from error
            console.print(write_library(folder, findings))
        console.print(f"Page: {folder / PAGE}")
    monitor.log("finished", exit_code=0)


def _read(libraries: list[Path], labels: Path | None, exact: bool) -> Library:
    """The library as the csv labels it, or by the names of its files.

    Raises ValueError if it cannot be understood; the message says why.
    """
    if labels is None:
        return labelled_by_name(libraries)
    if len(libraries) > 1:
        raise ValueError("--labels is of one LIBRARY: give the folder that holds them all")
    found = read_library(libraries[0], labels, exact)
    if lacking := [clip.file for clip in found.clips if not clip.source]:
        raise ValueError(f"{labels.name} gives {lacking[0]} no source: it needs a column 'source'")
    return found
