# SPDX-License-Identifier: GPL-3.0-or-later
"""The `w2w` command: its commands, and how it ends."""

from __future__ import annotations

import os
import sys
from itertools import pairwise
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from .blender import NoBlenderError
from .commands.calibrate import calibrate_sensor
from .commands.demo import demo
from .commands.export import export
from .commands.inspect import inspect
from .commands.place import place
from .commands.run import run
from .commands.sensors import sensors
from .commands.status import status
from .commands.synth import synth
from .console import NOTHING_TO_DO, too_little_memory
from .reports.html import report
from .stopping import ignore_signals, stop_on_signals
from .studies import add_studies
from .temporary import use_own_temporary_folder

PATHS = ("--out", "-o", "--plot")
"""Options that name what is written."""


def _show_version(asked: bool) -> None:
    if asked:
        from w2w.core.findings.summary import versions  # NumPy and more, which few commands need at once

        print(versions()["w2w"])
        raise typer.Exit


class _Commands(TyperGroup):
    """Refuses an empty path, which Python takes for the working directory."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        for before, text in pairwise(["", *args]):
            if text in [f"{option}=" for option in PATHS] or (
                not text and (before in PATHS or not before.startswith("-"))
            ):
                named = text.rstrip("=") or (before if before in PATHS else "An argument")
                ctx.fail(f"{named} is empty: name a file or a folder.")
        return super().parse_args(ctx, args)


APP = typer.Typer(
    name="w2w",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="""**Where to Wear**: find out where on the body a motion sensor (IMU) recognises activities best.

    W2W plays your motion clips on a human body with hundreds of virtual sensors, learns from each
    sensor's signal alone which activity it sees, and tells you the best spot and the smallest set
    of spots.

    First steps: `w2w demo` shows it all on a built-in library; `w2w run MY_CLIPS --out RESULTS`
    does the same with a folder of your own FBX, BVH or npz files; `w2w inspect FILE` tells what
    one file holds.
    """,
)


@APP.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None: ...


APP.command()(run)
APP.command()(demo)
APP.command()(place)
APP.command(name="inspect")(inspect)
APP.command()(report)
APP.command()(export)
APP.command()(synth)
APP.command()(sensors)
APP.command(name="calibrate")(calibrate_sensor)
APP.command()(status)
add_studies(APP)


def main(arguments: list[str] | None = None, program: str = "w2w") -> None:
    """Run the command line; ends the process with its exit code."""
    os.environ["PYTHONUTF8"] = "1"  # workers read text as Blender's own Python does, whatever the locale
    stop_on_signals()
    use_own_temporary_folder()
    try:
        APP(args=arguments, prog_name=program)
    except NoBlenderError as error:
        print(error, file=sys.stderr)
        raise SystemExit(NOTHING_TO_DO) from None
    except MemoryError as error:
        print(f"No result: {too_little_memory(error)}", file=sys.stderr)
        raise SystemExit(NOTHING_TO_DO) from None
    finally:
        ignore_signals()
