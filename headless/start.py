# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the `w2w` command begins: in a terminal, in the Blender program, or by a script's path."""

from __future__ import annotations

import signal
import sys

from .blender import find_libraries
from .stopping import stop_on_signals


def main() -> None:
    """Run the command line; ends the process with its exit code."""
    stop_on_signals()
    from .app import main as run

    run()


def run_script(*command: str) -> None:
    """Run what stands after ``--``, or after the script's name, as arguments of `command`.

    Raises
    ------
    SystemExit
        With the command's exit code, or a sentence where W2W's libraries are missing.
    """
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    find_libraries()
    _run([*command, *arguments], "w2w")


def run_arguments(arguments: list[str]) -> int:
    """Run ``blender --command w2w`` with what stands after it.

    Returns
    -------
    int
        The exit code.
    """
    try:
        find_libraries()
        _run(arguments, "blender --command w2w")
    except SystemExit as ended:
        if not isinstance(ended.code, str):
            return ended.code or 0
        print(ended.code, file=sys.stderr)
        return 1
    return 0


def _run(arguments: list[str], program: str) -> None:
    if "bpy" in sys.modules:
        signal.signal(signal.SIGINT, signal.default_int_handler)  # Blender's own would not stop a run
    from .app import main

    main(arguments, program)
