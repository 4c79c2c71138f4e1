# SPDX-License-Identifier: GPL-3.0-or-later
"""Standard streams that are closed, full, or that nobody reads any more: a sentence, never a traceback."""

from __future__ import annotations

import os
import sys
import threading
from typing import Any

STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))


def open_closed_streams() -> None:
    """Lead standard streams that are closed to nowhere, before a file that is opened gets their numbers."""
    for number, (name, mode) in enumerate(STREAMS):
        try:
            os.fstat(number)
        except OSError:
            _lead_nowhere(number)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def end_where_output_fails() -> None:
    """End the process with a sentence where its output cannot be written; errors are then not said."""
    for number, (name, _) in enumerate(STREAMS):
        stream = getattr(sys, name)
        if number and not isinstance(stream, _Output):
            setattr(sys, name, _Output(stream, number))


class _Output:
    """A stream that leads nowhere once it has failed.

    Of the standard output that ends the process: the main thread's next write raises SystemExit, which
    no `except` for errors of files takes for one of its own.
    """

    def __init__(self, stream: Any, number: int) -> None:
        self._stream, self._number, self._problem = stream, number, ""

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except OSError as error:
            self._fail(error)
            return len(text)
        finally:
            self._end()

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as error:
            self._fail(error)
        self._end()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _fail(self, error: OSError) -> None:
        _lead_nowhere(self._number)  # what is in the buffer, too
        if self._number == 1:
            self._problem = f"Stopped, because the output cannot be written: {error.strerror}."

    def _end(self) -> None:
        if self._problem and threading.current_thread() is threading.main_thread():
            problem, self._problem = self._problem, ""
            raise SystemExit(problem)


def _lead_nowhere(number: int) -> None:
    nowhere = os.open(os.devnull, os.O_RDWR)
    if nowhere != number:
        os.dup2(nowhere, number)
        os.close(nowhere)
    os.set_inheritable(number, True)
