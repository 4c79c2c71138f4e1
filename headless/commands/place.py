# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w place`: choose sensors again from a finished ranking, under a designer's constraints."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.files import write_json
from w2w.core.findings.advice_content import advice_content
from w2w.core.results_folder import StudyResults, choose_to_wear, sensors_together
from w2w.core.selection.advice import advise

from ..console import USAGE
from ..options import Costs, EveryActivity, Forbid, MaxPlaces, Must, Only, parse_wishes
from ..reports.advice_text import show_advice, show_best_spot, show_worn


def place(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    target: Annotated[
        float | None,
        typer.Option(
            min=0.01,
            max=1,
            help="F1 the set of sensors should reach.  [default: the run's]",
            show_default=False,
        ),
    ] = None,
    every_activity: EveryActivity = 0.0,
    only: Only = "",
    forbid: Forbid = "",
    must: Must = "",
    max_places: MaxPlaces = None,
    costs: Costs = None,
    together: Annotated[
        bool, typer.Option(help="Test the chosen sensors together by one classifier on all of them.")
    ] = True,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="json file to write the choice to.")] = None,
) -> None:
    """Choose sensors from a finished ranking under constraints, without baking anything again.

    Exit codes: 0 chosen, 2 wrong use or constraints that cannot be met (and why).
    """
    console = Console(highlight=False)
    try:
        study = StudyResults.load(results)
        goal = target if target is not None else study.parameters["target"]
        constraints = parse_wishes(only, forbid, must, costs)
        advice = advise(study.utility, study.patches, goal, max_places, constraints)
    except (ValueError, OSError) as error:
        console.print(f"[red]{error}[/red]")
        raise typer.Exit(USAGE) from error
    worn, tested = None, ()
    if together:
        wished = {"target": goal, "every_activity": every_activity, "max_places": max_places}
        with console.status("Choosing sensors to wear together"):
            worn = choose_to_wear(study, replace(study.config(), **wished, constraints=constraints))
            tested = sensors_together(study, advice.subset.order)
    show_best_spot(advice, study.utility, study.patches, console)
    if worn is not None:
        show_worn(worn, study.patches, console)
    show_advice(advice, study.utility, study.patches, tested, console)
    if out is not None:
        write_json(out, advice_content(advice, study.utility, study.patches, tested, worn))
        console.print(f"\nWritten to {out}")
