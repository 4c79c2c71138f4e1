# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of time and memory for worker processes, so that no file fills a machine, and where they print."""

import contextlib
import ctypes
import faulthandler
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TextIO

resource = import_module("resource") if find_spec("resource") else None  # Windows has none

LIMIT_S = 300.0
"""Seconds a clip may take before it is given up."""

MEMORY = 4 * 2**30
"""Bytes a worker may take: many times what a clip of minutes needs."""

PR_SET_PDEATHSIG = 1
"""Option of Linux's prctl: the signal to receive when the parent exits."""

LOOK_EVERY_S = 1.0


def end_with(parent: int) -> None:
    """End this process when the one that started it ends, even by SIGKILL.

    Linux does it at once, whatever Blender is doing; elsewhere a thread looks (not on Windows).
    """
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if resource is None:
        return
    if os.getppid() != parent:  # it ended before we could ask
        os._exit(1)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_EVERY_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


class _Watchdog:
    """Ends the process from outside the interpreter, and says so in a file, when the time is used up."""

    def __init__(self, seconds: float, file: TextIO) -> None:
        self.left, self.file = seconds, file

    def start(self) -> None:
        self.since = time.monotonic()
        faulthandler.dump_traceback_later(self.left, exit=True, file=self.file)

    def pause(self) -> None:
        faulthandler.cancel_dump_traceback_later()
        self.left = max(0.1, self.left - (time.monotonic() - self.since))


_WATCHDOGS: list[_Watchdog] = []


@contextlib.contextmanager
def guarded(limit_s: float = LIMIT_S, memory: int = MEMORY, marker: Path | None = None) -> Iterator[None]:
    """Bound the seconds and the bytes of data that a block of work may take in this process.

    Blender's importers are C++ and may hang where no Python exception reaches them: the watchdog's
    thread ends the process from outside the interpreter. More memory than the limit is refused by
    the system (Linux), which Python raises as a MemoryError; C++ may end the process on it.

    In the file `marker`, `timed_out` finds that the time was used up, and `crashed` a crash.
    """
    with Path(marker or os.devnull).open("a") as file, _memory_limit(memory):
        _WATCHDOGS.append(_Watchdog(limit_s, file))
        _WATCHDOGS[-1].start()
        before = sys.__stderr__ if faulthandler.is_enabled() else None
        faulthandler.enable(file)
        try:
            yield
        finally:
            _WATCHDOGS.pop().pause()
            faulthandler.disable()
            if before:
                faulthandler.enable(before)


@contextlib.contextmanager
def untimed() -> Iterator[None]:
    """Stop the watchdog while results are read or written: a slow folder is not the clip's fault."""
    if not _WATCHDOGS:
        yield
        return
    _WATCHDOGS[-1].pause()
    try:
        yield
    finally:
        _WATCHDOGS[-1].start()


def timed_out(marker: Path) -> bool:
    """Whether a process that `guarded` ended had used up its time."""
    return marker.is_file() and "Timeout (" in marker.read_text(errors="replace")


def crashed(marker: Path) -> bool:
    """Whether a process died of a fault of its own within `guarded`, not by someone's SIGKILL or SIGTERM."""
    return marker.is_file() and "Fatal Python error" in marker.read_text(errors="replace")


def allowed_memory() -> float:
    """Bytes that this process may take by limits from outside W2W (`ulimit`); infinite without any."""
    if resource is None:
        return float("inf")
    limits = (resource.getrlimit(resource.RLIMIT_DATA)[1], resource.getrlimit(resource.RLIMIT_AS)[0])
    return min((limit for limit in limits if limit != resource.RLIM_INFINITY), default=float("inf"))


@contextlib.contextmanager
def _memory_limit(memory: int) -> Iterator[None]:
    if resource is None:
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (int(min(memory, allowed_memory())), most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (before, most))


@contextlib.contextmanager
def output_to(path: Path) -> Iterator[None]:
    """Write what the process prints to a file, C++ included, even when it dies."""
    with path.open("w") as file:
        sys.stdout.flush()  # what was printed before is the user's
        saved = [os.dup(1), os.dup(2)]
        try:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
            yield
        finally:
            sys.stdout.flush()  # into a pipe it would come out later
            for number, handle in enumerate(saved, start=1):
                os.dup2(handle, number)
                os.close(handle)


def quiet_output() -> contextlib.AbstractContextManager[None]:
    """Keep what Blender's importers print from the user's screen."""
    return output_to(Path(os.devnull))
