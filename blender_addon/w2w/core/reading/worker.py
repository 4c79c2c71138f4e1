# SPDX-License-Identifier: GPL-3.0-or-later
"""The other end of a `ProgramExecutor`: a process that does the calls from its standard input.

Run as ``blender --background --python worker.py -- MARK`` or ``python worker.py -- MARK``. Blender and its
importers print on the standard output, so results take a copy of it, after a line with MARK, and all further
prints are dropped.
"""

import os
import pickle
import queue
import shutil
import site
import sys
import threading
from pathlib import Path
from typing import IO, Any

GONE = (EOFError, OSError, pickle.UnpicklingError)
"""Errors of reading a message where the process at the other end is gone, at its start or within it."""


def send(stream: IO[bytes], message: object) -> None:
    """Write a message that `pickle.load` reads; calls and answers are bytes, pickled by themselves before."""
    pickle.dump(message, stream)
    stream.flush()


def main(mark: str) -> None:
    """Do calls until the process at the other end is gone."""
    results = _take_output(mark)
    send(results, _session_folder())
    calls: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(calls,), daemon=True).start()
    folder, path = calls.get()
    os.chdir(folder)
    for place in path:  # Blender's own Python lacks the libraries that its parent has found
        if place and place not in sys.path:
            site.addsitedir(place)
    while True:
        send(results, _answer(calls.get()))


def _take_output(mark: str) -> IO[bytes]:
    """The standard output, for results alone."""
    sys.stdout.flush()
    results = os.fdopen(os.dup(1), "wb")
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    results.write(f"\n{mark}\n".encode())
    results.flush()
    return results


def _receive(calls: queue.SimpleQueue[Any]) -> None:
    """Queue the calls that come in; end with the process that makes them, whatever this one is doing."""
    stream = os.fdopen(os.dup(0), "rb")
    while True:
        try:
            calls.put(pickle.load(stream))  # noqa: S301 - from the process that started this one
        except GONE:
            shutil.rmtree(_session_folder(), ignore_errors=True)
            os._exit(1)


def _session_folder() -> str:
    """The folder that Blender made for this session and removes at a regular end, or "" without Blender."""
    return sys.modules["bpy"].app.tempdir if "bpy" in sys.modules else ""


def _answer(call: bytes) -> bytes:
    """Whether a call succeeded, and what it returned or raised."""
    try:
        return pickle.dumps((True, pickle.loads(call)()))  # noqa: S301 - from the process that started it
    except Exception as error:
        try:
            return pickle.dumps((False, error))
        except Exception:  # an exception that cannot travel
            return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))


if __name__ == "__main__":
    main(sys.argv[-1])
