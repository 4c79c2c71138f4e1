# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w need`: how cheap the sensor at a place may be."""

from pathlib import Path
from typing import Annotated

from ...core.files import write_json
from ...core.findings.advice_content import need_content, with_needs
from ...core.findings.summary import PLACEMENTS, write_placements
from ...core.study.choosing import find_needs
from ...core.study.results import REPORT, StudyResults
from .. import options
from ..console import USAGE, Terminal, ending
from ..options import argument, option
from ..reports.console_tables import show_need
from ..runs.own_files import check
from .report import amended

NAME = "need"
"""Name of the command for the note in a folder that is being changed."""


def need(
    results: Annotated[Path, argument("RESULTS", "Results folder of a finished run.")],
    place: Annotated[
        str,
        option(
            "Products and places, comma-separated: 'belt clip, left thigh front'.  [default: those that the "
            "run recommends, whose cards in report and tables then say it]",
            show_default=False,
        ),
    ] = "",
) -> None:
    """Find how slow, coarse, noisy and short in range the sensor at a place may be.

    The signals there are made again from the motions with each value, a classifier is trained and tested
    with it, and what costs at most .02 of F1 will do.

    Exit codes: 0 found, 2 wrong use, or a study whose signals cannot be made again, 4 a run is using
    RESULTS or was stopped there.
    """
    console = Terminal()
    with ending(USAGE, console):
        study = StudyResults.load(results, by="" if place else NAME)
        if not place:
            check(results, [PLACEMENTS, REPORT])
        with console.status("Trying cheaper sensors"):
            found = [need_content(one) for one in find_needs(study, options.words(place))]
    for one in found:
        show_need(one, console)
    if not place:
        with ending(USAGE, console), amended(results, ["summary.json", PLACEMENTS], NAME) as study:
            cards = with_needs(study.cards, found)
            write_placements(results, cards, study.patches)
            write_json(results / "summary.json", study.summary | {"cards": cards})
        console.print(f"\nWritten to the cards of {results}")
