# SPDX-License-Identifier: GPL-3.0-or-later
"""Entry points of the `w2w` command: in a terminal, in the Blender program, or by a script's path.

Standard streams may be closed, full, or read by nobody: that gives a sentence, never a traceback.
"""

import gc
import io
import os
import re
import sys
import threading
from collections.abc import Callable
from typing import Any

from ..core.wording import harmless
from .blender import find_libraries
from .stopping import stop_on_signals

STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))

STDERR = 2

COLOURS = re.compile(r"(\x1b\[[0-9;]*m)")
"""Control sequences that errors may send to a terminal; all others come from names and are removed."""


def main() -> None:
    """Run the command line; ends the process with its exit code."""
    _run(None, "w2w")


def run_script(*command: str) -> None:
    """Run `command` with the arguments after ``--``, or after the script's name; ends the process."""
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    _run([*command, *arguments], "w2w")


def run_arguments(arguments: list[str]) -> int:
    """Run ``blender --command w2w`` with its arguments; returns the exit code."""
    try:
        _run(arguments, "blender --command w2w")
    except SystemExit as ended:
        if not isinstance(ended.code, str):
            return ended.code or 0
        print(ended.code, file=sys.stderr)
        return 1
    return 0


def _run(arguments: list[str] | None, program: str) -> None:
    """Run the command line, by default with this process's arguments; a SystemExit ends it."""
    _ready_streams()
    stop_on_signals()  # Blender's own handler would not stop a run
    find_libraries()
    try:
        from .app import main as run_command

        run_command(arguments, program)
    except (ImportError, MemoryError) as error:
        if isinstance(error, ImportError) and "failed to map segment" not in str(error):
            raise
        raise SystemExit("There is too little memory for W2W to start (see ulimit -v).") from None
    finally:
        gc.freeze()  # as the process ends, all objects would be looked through again and again: .2 s of a run


def _ready_streams() -> None:
    """Lead closed standard streams to nowhere, before a file that is opened gets their numbers.

    Output that cannot be written then ends the process with a sentence; errors that cannot be are dropped.
    A name that the terminal cannot spell does no harm.
    """
    for number, (name, mode) in enumerate(STREAMS):
        try:
            os.fstat(number)
        except OSError:
            _lead_nowhere(number)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))
        stream = getattr(sys, name)
        if isinstance(stream, io.TextIOWrapper) and number:
            stream.reconfigure(errors="backslashreplace")
        if number and not isinstance(stream, _Output):
            setattr(sys, name, _Output(stream, number))


class _Output:
    """A stream that leads nowhere once it has failed.

    If the standard output fails, the process ends: the main thread's next write raises SystemExit, which
    no `except` for errors of files takes for one of its own. Errors quote names of files and arguments: a
    terminal obeys nothing in them. What goes to the standard output is made harmless by `console.Terminal`.
    """

    def __init__(self, stream: Any, number: int) -> None:
        self._stream, self._number, self._problem = stream, number, ""

    def write(self, text: str) -> int:
        if self._number == STDERR:
            parts = enumerate(COLOURS.split(text))
            text = "".join(part if place % 2 else harmless(part) for place, part in parts)
        self._do(self._stream.write, text)
        return len(text)

    def flush(self) -> None:
        self._do(self._stream.flush)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _do(self, work: Callable[..., object], *arguments: str) -> None:
        try:
            work(*arguments)
        except OSError as error:
            _lead_nowhere(self._number)  # what is in the buffer, too
            if self._number == 1:
                self._problem = f"Stopped, because the output cannot be written: {error.strerror}."
        if self._problem and threading.current_thread() is threading.main_thread():
            problem, self._problem = self._problem, ""
            raise SystemExit(problem)


def _lead_nowhere(number: int) -> None:
    nowhere = os.open(os.devnull, os.O_RDWR)
    if nowhere != number:
        os.dup2(nowhere, number)
        os.close(nowhere)
    os.set_inheritable(number, True)
