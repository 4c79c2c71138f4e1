# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study need`: may worn sensors be as cheap as the simulation says?"""

from pathlib import Path
from typing import Annotated

import typer

from w2w.core.wording import clean
from w2w.headless.console import USAGE, ending
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import published

from ..comparisons.needs import PAGE, of_protocol, of_utd, write_needs
from ..comparisons.truth import DATA_SETS
from .consoles import wide_console


def need(
    libraries: Annotated[
        list[Path], typer.Argument(metavar="LIBRARY...", help="Folders of motion files of the protocols.")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for page, table and picture.")],
    mhad: Annotated[Path | None, typer.Option(help="npz of Berkeley MHAD's accelerometers.")] = None,
    dsads: Annotated[Path | None, typer.Option(help="DSADS's folder, or an npz of it.")] = None,
    upfall: Annotated[
        Path | None, typer.Option(help="UP-Fall's CompleteDataSet.csv, or a folder of its trials.")
    ] = None,
    utd: Annotated[Path | None, typer.Option(help="UTD-MHAD's folder or npz.")] = None,
) -> None:
    """Lower rate, range and resolution of worn and of simulated sensors, and compare the F1 that it costs.

    Values and bars are fixed in W2W (docs/evidence/needs.md).

    Exit codes: 0 a page was written, 2 wrong use.
    """
    console, found = wide_console(), []
    given = {"dsads": dsads, "mhad": mhad, "upfall": upfall}
    with (
        ending(USAGE, console),
        published(out, [path for path in (*given.values(), utd) if path]) as folder,
    ):
        for name, path in given.items():
            if path:
                with RunMonitor(console).step(f"comparing {DATA_SETS[name].name}"):
                    found += of_protocol(DATA_SETS[name], path, libraries, console.print)
        if utd:
            with RunMonitor(console).step("comparing UTD-MHAD"):
                found += of_utd(utd)
        if not found:
            raise ValueError("Point it to a data set at least: --dsads, --mhad, --upfall, --utd")
        console.print(write_needs(folder, found))
    console.print(f"Page: {clean(out / PAGE)}")
