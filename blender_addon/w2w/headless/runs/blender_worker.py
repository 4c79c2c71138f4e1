# SPDX-License-Identifier: GPL-3.0-or-later
"""The other end of a `BlenderExecutor`: a background Blender that does the calls from its standard input.

Run as ``blender --background --python blender_worker.py -- MARK``. Blender and its importers print on the
standard output, so results take a copy of it, after a line with MARK, and all further prints are dropped.
"""

import os
import pickle
import queue
import shutil
import struct
import sys
import threading
from pathlib import Path
from typing import IO

HEADER = struct.Struct("<Q")


def write_frame(stream: IO[bytes], payload: bytes) -> None:
    stream.write(HEADER.pack(len(payload)) + payload)
    stream.flush()


def read_frame(stream: IO[bytes]) -> bytes:
    """Read one message; an EOFError where the process at the other end is gone."""
    (length,) = HEADER.unpack(_read(stream, HEADER.size))
    return _read(stream, length)


def _read(stream: IO[bytes], length: int) -> bytes:
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return content


def main(mark: str) -> None:
    """Do calls until the process at the other end is gone."""
    results = _take_output(mark)
    write_frame(results, _session_folder().encode())
    calls: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(calls,), daemon=True).start()
    folder, sys.path[:] = pickle.loads(calls.get())  # noqa: S301 - from the process that started this one
    os.chdir(folder)
    while True:
        write_frame(results, _answer(calls.get()))


def _take_output(mark: str) -> IO[bytes]:
    """The standard output, for results alone."""
    sys.stdout.flush()
    results = os.fdopen(os.dup(1), "wb")
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    results.write(f"\n{mark}\n".encode())
    results.flush()
    return results


def _receive(calls: queue.SimpleQueue[bytes]) -> None:
    """Queue the calls that come in; end with the process that makes them, whatever this one is doing."""
    stream = os.fdopen(os.dup(0), "rb")
    while True:
        try:
            calls.put(read_frame(stream))
        except (EOFError, OSError):
            shutil.rmtree(_session_folder(), ignore_errors=True)
            os._exit(1)


def _session_folder() -> str:
    """The folder that Blender made for this session and removes at a regular end; empty without Blender."""
    return sys.modules["bpy"].app.tempdir if "bpy" in sys.modules else ""


def _answer(call: bytes) -> bytes:
    """Whether a call succeeded, and what it returned or raised."""
    try:
        work = pickle.loads(call)  # noqa: S301 - from the process that started this one
        return pickle.dumps((True, work()))
    except Exception as error:
        try:
            return pickle.dumps((False, error))
        except Exception:  # an exception that cannot travel
            return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))


if __name__ == "__main__":
    main(sys.argv[-1])
