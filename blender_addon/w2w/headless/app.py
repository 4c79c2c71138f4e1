# SPDX-License-Identifier: GPL-3.0-or-later
"""The `w2w` command: its commands, each imported when it is called, and how it ends."""

import ast
import atexit
import gc
import os
import shutil
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import typer
from filelock import FileLock, Timeout
from typer.core import TyperCommand, TyperGroup

from .blender import NoBlenderError
from .stopping import always_when_stopped, ignore_signals, stop_on_signals

GROUP = "w2w.command"
"""Entry points by which installed packages add commands, as the studies do: ``name = "module:function"``."""


class LazyGroup(TyperGroup):
    """Commands of entry points: those of `OWN`, then W2W's others, and other packages' under their names.

    A function becomes a command, a `typer.Typer` a group.
    """

    OWN: tuple[EntryPoint, ...] = ()

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        others = entry_points(group=GROUP)
        self.points = {point.name: point for point in (*self.OWN, *others)}
        self.commands: dict[str, Any] = dict.fromkeys(self.points)  # typer suggests one of them
        self._listing = False

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002 - typer's own arguments
        if cmd_name not in self.points or self.commands[cmd_name]:
            return self.commands.get(cmd_name)
        point = self.points[cmd_name]
        foreign = point.dist and point.module.partition(".")[0] != __package__.partition(".")[0]
        panel = point.dist.name if foreign else None
        if self._listing:
            return TyperCommand(cmd_name, help=first_line(point), rich_help_panel=panel)
        self.commands[cmd_name] = _loaded(point, panel)
        return self.commands[cmd_name]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        self._listing = True
        try:
            super().format_help(ctx, formatter)
        finally:
            self._listing = False


def _loaded(point: EntryPoint, panel: str | None) -> Any:
    what = getattr(import_module(point.module), point.attr)
    app = typer.Typer(add_completion=False, rich_markup_mode="markdown")
    app.callback()(lambda: None)  # so that it is a group, even of one command
    if isinstance(what, typer.Typer):
        app.add_typer(what, name=point.name, rich_help_panel=panel)
    else:
        app.command(point.name, rich_help_panel=panel)(what)
    return typer.main.get_group(app).commands[point.name]


def first_line(point: EntryPoint) -> str:
    """The first line of a command's help, read from its source.

    That is its function's docstring or, of a group, the `help` of its `typer.Typer`. "" if its module is not
    there.
    """
    spec = find_spec(point.module)
    if spec is None or spec.origin is None:
        return ""
    for made in ast.parse(Path(spec.origin).read_bytes()).body:
        if isinstance(made, ast.FunctionDef) and made.name == point.attr:
            return (ast.get_docstring(made) or "").partition("\n")[0]
        if isinstance(made, ast.Assign) and ast.unparse(made.targets[0]) == point.attr:
            given = {word.arg: word.value for word in getattr(made.value, "keywords", ())}
            return ast.literal_eval(given["help"]) if "help" in given else ""
    return ""


PATHS = ("--out", "-o", "--plot")
"""Options that name what is written."""

HOW_TO_GET_STUDIES = (
    "The commands of W2W's studies are a package of their own, which is not installed here: run "
    "pip install '.[blender]' ./packages/studies in W2W's source folder, and then the command in a terminal."
)

PREFIX = "w2w-run-"


def _show_version(asked: bool) -> None:
    if asked:
        from ..core.findings.summary import versions  # NumPy and more, which few commands need at once

        print(versions()["w2w"])
        raise typer.Exit


class _Commands(LazyGroup):
    """Refuses an empty path, which Python takes for the working directory."""

    OWN = tuple(
        EntryPoint(name.replace("_", "-"), f"{__package__}.commands.{name}:{name}", GROUP)
        for name in (
            "run", "init", "demo", "place", "need", "inspect", "report", "export", "synth", "sensors",
            "rank_recordings", "pilot", "calibrate", "status",
        )
    )  # fmt: skip

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        for before, text in pairwise(["", *args]):
            if text in [f"{option}=" for option in PATHS] or (
                not text and (before in PATHS or not before.startswith("-"))
            ):
                named = text.rstrip("=") or (before if before in PATHS else "An argument")
                ctx.fail(f"{named} is empty: name a file or a folder.")
        return super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args[0] not in self.commands and "study" not in self.commands:
            typer.echo(HOW_TO_GET_STUDIES, err=True)
        return super().resolve_command(ctx, args)


APP = typer.Typer(
    name="w2w",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)


@APP.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """**Where to Wear**: find out where on the body a motion sensor (IMU) recognises activities best.

    W2W plays your motion clips on a human body with hundreds of virtual sensors, learns from each
    sensor's signal alone which activity it sees, and tells you the best spot and the smallest set
    of spots.

    First steps: `w2w demo` shows it all on a built-in library; `w2w run MY_CLIPS --out RESULTS`
    does the same with a folder of your own FBX, BVH or npz files; `w2w inspect FILE` tells what
    one file holds.
    """


def use_own_temporary_folder() -> None:
    """Make a temporary folder for this process and its children, and remove those of killed processes.

    Where none can be made, everything stays as it is.
    """
    for other in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError, Timeout):  # its process lives
            mine = not hasattr(os, "getuid") or other.lstat().st_uid == os.getuid()
            if mine and (other / "lock").is_file():  # one without a lock is just being made
                with FileLock(other / "lock", timeout=0):
                    shutil.rmtree(other, ignore_errors=True)
    try:
        folder = tempfile.mkdtemp(prefix=PREFIX)
        lock = FileLock(Path(folder, "lock"))
        lock.acquire(timeout=0)
    except (OSError, Timeout):
        return
    os.environ.update(dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder))  # where Python and Blender look
    tempfile.tempdir = folder

    def remove() -> None:
        lock.release()  # Windows removes no open file
        shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    always_when_stopped(remove)
    always_when_stopped(_remove_blenders)


def _remove_blenders() -> None:
    """Remove the folder that the Blender program made before it started W2W."""
    if "bpy" in sys.modules:
        folder = Path(sys.modules["bpy"].app.tempdir)
        if folder.name.startswith("blender_"):
            shutil.rmtree(folder, ignore_errors=True)


def main(arguments: list[str] | None = None, program: str = "w2w") -> None:
    """Run the command line; ends the process with its exit code."""
    os.environ["PYTHONUTF8"] = "1"  # workers read text as Blender's own Python does, whatever the locale
    os.environ["PYTHONSAFEPATH"] = "1"  # no child imports what lies in the current directory
    gc.set_threshold(200_000, 20, 100)  # a large library is many objects, hardly any of them garbage
    stop_on_signals()
    use_own_temporary_folder()
    try:
        APP(args=arguments, prog_name=program)
    except (NoBlenderError, MemoryError, OSError) as error:
        from .console import NOTHING_TO_DO, sentence_of  # rich, which no command's help needs

        said = str(error) if isinstance(error, NoBlenderError) else f"No result: {sentence_of(error)}"
        print(said, file=sys.stderr)
        raise SystemExit(NOTHING_TO_DO) from None
    finally:
        ignore_signals()
