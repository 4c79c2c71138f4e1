# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w report`: write the page of a finished study."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from ...core.files import write_text
from ...core.study.clip_files import WORK, mark_changing, mark_whole
from ...core.study.results import REPORT, StudyResults
from ..console import USAGE, Terminal, ending
from ..options import argument, option
from ..runs.folder import only_run, remove_unfinished
from ..runs.own_files import claimed, list_written


def report(
    results: Annotated[Path, argument("RESULTS", "Results folder of a finished run.")],
    project: Annotated[
        str | None, option("Project name on the page.  [default: the run's]", "--title")
    ] = None,
) -> None:
    """Write `report.html` into a finished results folder: the heatmaps in 3D, the choice, the tables.

    The page is one file and needs no network. `w2w run` writes it by itself.

    Exit codes: 0 written, 2 the folder holds no finished run, 4 its run is unfinished.
    """
    console = Terminal()
    with ending(USAGE, console):
        path = write_report(results, project)
    console.print(f"Report: {path}")


def write_report(out: Path, project: str | None = None, *, by: str | None = "") -> Path:
    """Write a finished study's `report.html` into its folder, under the run's title or another.

    A ValueError says that the folder holds no finished run, or a foreign `report.html`; `by` is as in
    `StudyResults.load`.
    """
    from ...report.page import report_page  # jinja2 is slow to import

    page = report_page(StudyResults.load(out, by=by), project)
    with claimed(out, [REPORT]):
        write_text(out / REPORT, page)
    return out / REPORT


@contextmanager
def amended(out: Path, tables: Sequence[str], by: str) -> Iterator[StudyResults]:
    """A finished study, of which the block writes some tables anew; the report follows.

    `by` is the command for the note in a folder that is being changed; no other run works there meanwhile.
    """
    with only_run(out / WORK):
        study = StudyResults.load(out, by=by)
        remove_unfinished(out)
        mark_changing(out, by=by)
        with list_written(out, tables):
            yield study
        write_report(out, by=None)
        mark_whole(out)
