# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study truth`: does the simulation rank sites as people's real sensors do, on all sets at hand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from w2w.core.motion.source import UnusableMotion

from ..console import USAGE
from ..reports.console_tables import wide_console
from ..runs.monitor import RunMonitor
from ..validation.truth import DATA_SETS, PAGE, run_data_set, write_page


def truth(
    libraries: Annotated[
        list[Path],
        typer.Argument(metavar="LIBRARY...", help="Folders of motion files, and UTD-MHAD's folder or npz."),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for truth.md and a folder a data set.")],
    mhad: Annotated[Path | None, typer.Option(help="npz of Berkeley MHAD's accelerometers.")] = None,
    umafall: Annotated[Path | None, typer.Option(help="npz of UMAFall.")] = None,
    dsads: Annotated[Path | None, typer.Option(help="DSADS's folder, or an npz of it.")] = None,
    upfall: Annotated[Path | None, typer.Option(help="UP-Fall's CompleteDataSet.csv, or its folder.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of folds, bootstrap and sensor errors.")] = 0,
) -> None:
    """Compare worn with simulated sensors on every data set you point it to, and write one page.

    Activities, sites, windows and bars of each set are fixed in W2W (docs/truth.md). A set that cannot be
    used is left out, and why is said.

    Exit codes: 0 a page was written, 2 wrong use, or no set could be used.
    """
    console = wide_console()
    given = {name: path for name, path in zip(DATA_SETS, (mhad, umafall, dsads, upfall), strict=True) if path}
    if not given:
        options = ", ".join(f"--{name}" for name in DATA_SETS)
        console.print(f"[red]Point it to a data set at least: {options}[/red]")
        raise typer.Exit(USAGE)
    found = {}
    for name, path in given.items():
        try:
            with RunMonitor(console).step(f"comparing {DATA_SETS[name].protocol.name}"):
                found[name], _ = run_data_set(name, path, libraries, out / name, seed, console.print)
        except (ValueError, OSError, UnusableMotion) as error:
            console.print(f"{DATA_SETS[name].protocol.name} is left out: {error}", style="red", markup=False)
    if not found:
        raise typer.Exit(USAGE)
    console.print(write_page(out, found), markup=False)
    console.print(f"Page: {out / PAGE}")
