# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the `w2w` command begins: in a terminal, in the Blender program, or by a script's path."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable

from .blender import find_libraries
from .standard_streams import open_closed_streams
from .stopping import stop_on_signals


def main() -> None:
    """Run the command line; ends the process with its exit code."""
    open_closed_streams()
    stop_on_signals()
    _commands()()


def run_script(*command: str) -> None:
    """Run `command` with the arguments after ``--``, or after the script's name; ends the process."""
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    open_closed_streams()
    _run([*command, *arguments], "w2w")


def run_arguments(arguments: list[str]) -> int:
    """Run ``blender --command w2w`` with its arguments; returns the exit code."""
    open_closed_streams()
    try:
        _run(arguments, "blender --command w2w")
    except SystemExit as ended:
        if not isinstance(ended.code, str):
            return ended.code or 0
        print(ended.code, file=sys.stderr)
        return 1
    return 0


def _run(arguments: list[str], program: str) -> None:
    find_libraries()
    if "bpy" in sys.modules:
        signal.signal(signal.SIGINT, signal.default_int_handler)  # Blender's own would not stop a run
    _commands()(arguments, program)


def _commands() -> Callable[..., None]:
    """Import the command line; a SystemExit with a sentence says that there is too little memory for it."""
    try:
        from .app import main
    except (ImportError, MemoryError) as error:
        if isinstance(error, ImportError) and "failed to map segment" not in str(error):
            raise
        raise SystemExit("There is too little memory for W2W to start (see ulimit -v).") from None
    return main
