# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w pilot`: what people who wore a sensor at a place or two say of the level of the whole map."""

from pathlib import Path
from typing import Annotated

from ...core.files import write_json
from ...core.findings.pilot import Pilot, of_folder
from ...core.study.results import REPORT, StudyResults
from ..console import USAGE, console_beside, ending, print_json
from ..options import AsJson, argument, option
from ..reports.console_tables import show_cautions
from ..runs.own_files import check
from .report import amended

NAME = "pilot"
"""Name of the command for the note in a folder that is being changed."""


def pilot(
    results: Annotated[Path, argument("RESULTS", "Results folder of a finished run.")],
    recordings: Annotated[
        Path,
        argument("RECORDINGS", "Folder of what people wore: exports of phone apps, labels.csv."),
    ],
    at: Annotated[
        str,
        option(
            "Where it was worn: 'left wrist', 'belt clip'. Folders and files then say who and what: "
            "anna/walking.csv.  [default: what labels, files or ACTIVITY/CLIP/PLACE.csv say]",
            show_default=False,
        ),
    ] = "",
    as_json: AsJson = False,
) -> None:
    """Hold recordings of a few people against the map: its level moves to them, the order of places stays.

    Report and summary.json of RESULTS then say both, with the pilot and without.

    Exit codes: 0 found, 2 wrong use or recordings that cannot be used (and why), 4 a run is using
    RESULTS or was stopped there.
    """
    console = console_beside(as_json)
    with ending(USAGE, console):
        study = StudyResults.load(results, by=NAME)
        check(results, [REPORT])
        found = of_folder(study, recordings, at)
        write_pilot(results, found)
    console.print(found.sentence(), style="bold")
    console.print(found.next())
    show_cautions(found.cautions, console)
    for file, why in found.skipped:
        console.print(f"Left out: {file}: {why}", style="yellow")
    console.print(f"\nWritten to summary and report of {results}")
    if as_json:
        print_json(found.content())


def write_pilot(out: Path, found: Pilot) -> None:
    """Write a pilot beside the answer, into summary and report of a results folder."""
    with amended(out, ["summary.json"], NAME) as study:
        write_json(out / "summary.json", study.summary | {"pilot": found.content()})
