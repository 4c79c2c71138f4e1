# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w challenge`: anybody's ranking of sites, judged by the people of five data sets."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.files import write_text
from w2w.core.wording import clean
from w2w.headless.console import USAGE, ending
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import published

from ..comparisons.challenge import (
    HEADINGS,
    UTD,
    Method,
    judge_of,
    judge_of_utd,
    method_csv,
    read_method,
    table_of,
)
from ..comparisons.challenge_baselines import baselines, baselines_of_utd
from ..comparisons.truth import DATA_SETS
from .consoles import wide_console

PAGE, RANKINGS = "challenge.md", "rankings"


def challenge(
    rankings: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="RANKINGS...", help="csv files with columns data_set, site, score[, activity]."
        ),
    ] = None,
    *,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for challenge.md and rankings.")],
    mhad: Annotated[Path | None, typer.Option(help="npz of Berkeley MHAD's accelerometers.")] = None,
    umafall: Annotated[Path | None, typer.Option(help="npz of UMAFall.")] = None,
    dsads: Annotated[Path | None, typer.Option(help="DSADS's folder, or an npz of it.")] = None,
    upfall: Annotated[
        Path | None, typer.Option(help="UP-Fall's CompleteDataSet.csv, or a folder of its trials.")
    ] = None,
    utd: Annotated[Path | None, typer.Option(help="UTD-MHAD's folder or npz.")] = None,
    library: Annotated[
        list[Path] | None,
        typer.Option(help="Motion files that baselines are made from; once for each folder."),
    ] = None,
) -> None:
    """Score rankings of sites on people's worn sensors, against a random choice and what people reach.

    A csv has a score for each site of a data set, or for each activity and site; higher is better. Data sets
    are called Berkeley MHAD, UMAFall, DSADS, UP-Fall and UTD-MHAD (docs/studies.md has their sites and
    activities). With --library, four baselines are ranked as well, and written as such csv files.

    Exit codes: 0 a table was written, 2 wrong use.
    """
    console = wide_console()
    given = {"mhad": mhad, "umafall": umafall, "dsads": dsads, "upfall": upfall}
    given = {name: path for name, path in given.items() if path}
    with ending(USAGE, console):
        if not given and utd is None:
            raise ValueError("Point it to a data set at least: --mhad, --umafall, --dsads, --upfall or --utd")
        methods: dict[str, Method] = {path.stem: read_method(path) for path in rankings or ()}
        with published(out, (*given.values(), utd, *(rankings or ()))) as folder:
            _judge(given, utd, methods, library or [], folder, console)
    console.print(f"Page: {clean(out / PAGE)}")


def _judge(
    given: dict[str, Path],
    utd: Path | None,
    methods: dict[str, Method],
    libraries: list[Path],
    out: Path,
    console: Console,
) -> None:
    monitor = RunMonitor(console)
    judges, made = [], {}
    for name, path in given.items():
        protocol = DATA_SETS[name]
        with monitor.step(f"judging by {protocol.name}"):
            judges.append(judge_of(protocol, path))
            if libraries:
                made[protocol.name] = baselines(protocol, libraries)
    if utd is not None:
        with monitor.step(f"judging by {UTD}"):
            judges.append(judge_of_utd(utd))
            if libraries:
                made[UTD] = baselines_of_utd(utd)
    for data_set, of_data_set in made.items():
        for name, scores in of_data_set.items():
            methods.setdefault(name, {})[data_set] = scores
    (out / RANKINGS).mkdir()
    for name in dict.fromkeys(name for found in made.values() for name in found):
        write_text(out / RANKINGS / f"{name}.csv", method_csv(methods[name]))
    rows = table_of(judges, methods)
    lines = ["| " + " | ".join(cells) + " |" for cells in (HEADINGS, ["---"] * len(HEADINGS), *rows)]
    text = "\n".join(["# The placement challenge", "", *lines, ""])
    write_text(out / PAGE, text)
    console.print(text)
