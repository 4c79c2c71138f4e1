# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study paper`: the sets that the paper's algorithm 2 and its exact optimum choose from a run."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from w2w.core.files import write_json
from w2w.core.parameters import with_values
from w2w.core.study.results import StudyResults
from w2w.core.wording import capital
from w2w.headless.console import USAGE, ending
from w2w.headless.runs.own_files import check, claimed
from w2w.headless.study_options import declared, values_of

from ..paper.sets import PaperSets, paper_sets, sets_content
from .consoles import wide_console

WRITTEN = "paper_sets.json"


def paper(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    target: Annotated[
        float | None,
        declared("target", help="Mean-max F1 to reach.  [default: the run's]", show_default=False),
    ] = None,
    only: Annotated[str | None, declared("only")] = None,
    forbid: Annotated[str | None, declared("forbid")] = None,
    must: Annotated[str | None, declared("must")] = None,
    max_places: Annotated[int | None, declared("max_places")] = None,
    costs: Annotated[Path | None, declared("costs")] = None,
) -> None:
    """Choose sensors as the paper does: by algorithm 2, with the exact optimum of its proxy.

    The proxy, mean-max F1, takes each activity from the sensor that is best at it, on the very clips that
    choose. Beside it stand the paper's joint test, one classifier on all sensors, and what other clips would
    give. Written to `RESULTS/paper_sets.json`; what is not given is as in the run.

    Exit codes: 0 chosen, 2 wrong use or constraints that cannot be met.
    """
    console = wide_console()
    with ending(USAGE, console):
        study = StudyResults.load(results)
        wished = {"target": target, "max_places": max_places, "only": only, "forbid": forbid, "must": must}
        wished = {name: value for name, value in (wished | {"costs": costs}).items() if value is not None}
        config = with_values(study.config(), values_of(wished))
        check(results, [WRITTEN])
        with console.status("Choosing and testing sets"):
            sets = paper_sets(study, config)
    show_sets(sets, study, console)
    with claimed(results, [WRITTEN]):
        write_json(results / WRITTEN, sets_content(sets, study))
    console.print(f"Sets: {results / WRITTEN}")


def show_sets(sets: PaperSets, study: StudyResults, console: Console) -> None:
    """Print algorithm 2's set sensor by sensor, its joint test and the exact optimum."""
    greedy, names = sets.greedy, study.patches.names
    table = Table(title="By the paper's algorithm 2, sensor by sensor", title_justify="left")
    for heading in ("", "patch", "mean-max F1", "joint F1", "expected F1"):
        table.add_column(heading, justify="left" if heading == "patch" else "right", overflow="fold")
    for number, (patch, score) in enumerate(zip(greedy.order, greedy.mean_max_after_each, strict=True)):
        joint = f"{sets.together[number].mean[0]:.3f}" if number < len(sets.together) else ""
        expected = "" if greedy.promise is None else f"{greedy.promise.mean[number]:.3f}"
        table.add_row(str(number + 1), names[patch], f"{score:.3f}", joint, expected)
    console.print(table)
    console.print(f"{capital(greedy.sentence())}.")
    if joint := sets.joint():
        console.print(f"{capital(joint['sentence'])}.")
    exact = "" if sets.exact is None else f": {', '.join(names[patch] for patch in sets.exact.order)}"
    console.print(f"{capital(sets.gap_sentence())}{exact}.")
    if sets.exact is not None and set(sets.exact.order) != set(greedy.order):
        console.print(f"The exact optimum: {sets.exact.expected_sentence()}.")
