# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study prior`: what is generally good, from finished runs of your own libraries."""

from pathlib import Path
from typing import Annotated

import typer

from w2w.core.files import write_json
from w2w.core.wording import count
from w2w.headless.console import USAGE, ending
from w2w.headless.runs.own_files import new_file

from ..comparisons.prior import general
from .consoles import wide_console


def prior(
    families: Annotated[
        list[Path],
        typer.Argument(
            metavar="FAMILY...",
            help="Folders, each of the results folders of libraries that are alike: one lab's, one maker's.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="JSON file to write.")],
) -> None:
    """Average how regions of the body do in several families of libraries: what is generally good.

    A family that is left out has no part in the prior that its own choices are held against.

    Exit codes: 0 written, 2 wrong use.
    """
    console = wide_console()
    with ending(USAGE, console):
        new_file(out)
        found = general(families)
        write_json(out, found)
    console.print(f"{count('region', len(found['regions']))} of {count('family', len(families))}: {out}")
