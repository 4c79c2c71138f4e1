# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w sweep`: does the ranking hold at another tempo, on another body, with another sensor?"""

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.study.results import StudyResults
from w2w.headless.console import NOTHING_TO_DO, USAGE, ending
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import check, claimed

from ..sweep.cases import FACTORS, cases
from ..sweep.maps import SweepMaps
from ..sweep.report import SweptCase, show_sweep, write_sweep
from ..sweep.sensitivity import compare_maps
from .consoles import wide_console

SWEEP_FILES = ("sweep.csv", "places.csv", "sweep.png")
USUAL_FACTORS = "tempo,asymmetry,body,sensor,window"


def sweep(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    by: Annotated[
        str, typer.Option(help=f"What to change, one at a time, comma-separated: {', '.join(FACTORS)}.")
    ] = USUAL_FACTORS,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Output folder.  [default: RESULTS/sweep]", show_default=False),
    ] = None,
    patches: Annotated[
        int, typer.Option(min=8, help="Patches compared, spread evenly; at most those of the run.")
    ] = 128,
    workers: Annotated[int, typer.Option(min=1, help="Clips worked on at the same time.")] = os.cpu_count()
    or 1,
) -> None:
    """Rank a finished run's motions again under other conditions, and show where the ranking holds.

    The motions are not read from their files again, and what an earlier sweep finished is taken up.

    Exit codes: 0 done, 1 a map cannot be made (and why), 2 wrong use, 130 stopped by Ctrl-C.
    """
    from ..sweep.figure import sweep_figure  # matplotlib is slow to import

    console = wide_console()
    with ending(USAGE, console):
        study = StudyResults.load(results)
        wanted = cases(
            study.config(), [name.strip().replace("-", " ") for name in by.split(",") if name.strip()]
        )
        folder = out or results / "sweep"
        check(folder, SWEEP_FILES)
        maps = SweepMaps(study, folder, patches, workers)
    swept = _sweep(maps, wanted, len(study.clips), console)
    with claimed(folder, SWEEP_FILES):
        write_sweep(folder, swept, maps.patches)
        sweep_figure(folder / "sweep.png", swept, maps.patches)
    show_sweep(swept, maps.patches, console)
    console.print(
        f"\nTables:  {folder / 'sweep.csv'}, {folder / 'places.csv'}\nPicture: {folder / 'sweep.png'}"
    )


def _sweep(maps: SweepMaps, wanted: list, n_clips: int, console: Console) -> list[SweptCase]:
    monitor, swept = RunMonitor(console), []
    try:
        for case in wanted:
            with monitor.bar(case.title, n_clips) as advance:
                utility = maps.map_of(case, advance)
            usual = swept[0].utility if swept else utility
            swept.append(SweptCase(case, utility, compare_maps(usual, utility)))
    except ValueError as error:
        console.print(f"{case.title}: {error}", style="red")
        raise typer.Exit(NOTHING_TO_DO) from error
    return swept
