# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of W2W's studies; where those are not installed, how to get them."""

from __future__ import annotations

from importlib.util import find_spec

import typer

from .console import NOTHING_TO_DO

COMMANDS = ("tables", "sweep", "dsads", "demo-library", "study", "validate")


def add_studies(app: typer.Typer) -> None:
    """Add the commands of the studies, or sentences in their place."""
    if find_spec("w2w.studies") is not None:
        from w2w.studies.commands import add_commands

        add_commands(app, "Studies")
        return
    anything = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}
    for name in COMMANDS:
        app.command(name, hidden=True, context_settings=anything)(_say_how_to_get_them)


def _say_how_to_get_them(context: typer.Context) -> None:
    typer.echo(
        f"w2w {context.info_name} is one of W2W's studies, which Blender's extension does not hold: "
        "run pip install '.[blender]' in W2W's source folder, and then the same command in a terminal.",
        err=True,
    )
    raise typer.Exit(NOTHING_TO_DO)
