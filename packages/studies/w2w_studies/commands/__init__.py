# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of the studies, for `w2w`."""

import typer

from .challenge import challenge
from .demo_library import demo_library
from .study import STUDY
from .sweep import sweep
from .tables import tables
from .validate import VALIDATE


def add_commands(app: typer.Typer, panel: str = "Studies") -> None:
    """Add them to the command line, under a heading of their own."""
    for command in (tables, sweep, challenge):
        app.command(rich_help_panel=panel)(command)
    app.command(name="demo-library", rich_help_panel=panel)(demo_library)
    app.add_typer(STUDY, name="study", rich_help_panel=panel)
    app.add_typer(VALIDATE, name="validate", rich_help_panel=panel)
