# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study truth`: does the simulation rank sites as people's real sensors do, on all sets at hand."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.motion.source import UnusableMotion
from w2w.core.wording import clean
from w2w.headless.console import USAGE, ending, sentence_of
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import published

from ..comparisons.protocol_report import write_protocol
from ..comparisons.truth import DATA_SETS, PAGE, against_libraries, mighar_set, write_page
from .consoles import wide_console


def truth(
    libraries: Annotated[
        list[Path],
        typer.Argument(metavar="LIBRARY...", help="Folders of motion files, and UTD-MHAD's folder or npz."),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for truth.md and a folder a data set.")],
    mhad: Annotated[Path | None, typer.Option(help="npz of Berkeley MHAD's accelerometers.")] = None,
    umafall: Annotated[Path | None, typer.Option(help="npz of UMAFall.")] = None,
    dsads: Annotated[Path | None, typer.Option(help="DSADS's folder, or an npz of it.")] = None,
    upfall: Annotated[
        Path | None, typer.Option(help="UP-Fall's CompleteDataSet.csv, or a folder of its trials.")
    ] = None,
    mighar: Annotated[
        Path | None, typer.Option(help="MIG HAR's folder of subject1 to 12; needs --sensors.")
    ] = None,
    sensors: Annotated[
        Path | None, typer.Option(help="csv of where MIG HAR's sensors sit, as for `w2w validate mighar`.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of folds, bootstrap and sensor errors.")] = 0,
) -> None:
    """Compare worn with simulated sensors on every data set you point it to, and write one page.

    Activities, sites, windows and bars of each set are fixed in W2W (docs/truth.md). A set that cannot be
    used is left out, and why is said.

    Exit codes: 0 a page was written, 2 wrong use, or no set could be used.
    """
    console = wide_console()
    given = {"mhad": mhad, "umafall": umafall, "dsads": dsads, "upfall": upfall, "mighar": mighar}
    given = {name: path for name, path in given.items() if path}
    with ending(USAGE, console):
        if not given:
            options = ", ".join(f"--{name}" for name in (*DATA_SETS, "mighar"))
            raise ValueError(f"Point it to a data set at least: {options}")
        if mighar and sensors is None:
            raise ValueError("--mighar needs --sensors: `w2w validate mighar` writes an empty one to fill in")
        with published(out, (*given.values(), sensors)) as folder:
            _compare(given, libraries, sensors, seed, folder, console)
    console.print(f"Page: {clean(out / PAGE)}")


def _compare(
    given: Mapping[str, Path],
    libraries: list[Path],
    sensors: Path | None,
    seed: int,
    out: Path,
    console: Console,
) -> None:
    """Compare set by set, and write the page.

    Raises typer.Exit if no set can be used.
    """
    found, names = {}, {}
    for name, path in given.items():
        try:
            protocol = DATA_SETS[name] if name in DATA_SETS else mighar_set(sensors, console.print)
            names[name] = protocol.name
            with RunMonitor(console).step(f"comparing {names[name]}"):
                of_set = against_libraries(protocol, path, libraries, seed, console.print)
                write_protocol(out / name, protocol, of_set)
            found[name] = of_set
        except (ValueError, OSError, UnusableMotion) as error:
            console.print(f"{names.get(name, name)} is left out: {sentence_of(error)}", style="red")
    if not found:
        raise typer.Exit(USAGE)
    console.print(write_page(out, found, names))
