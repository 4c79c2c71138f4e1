# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker process may take: time and memory, so that no file can hang or fill a machine."""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

try:
    import resource
except ModuleNotFoundError:  # Windows has none
    resource = None

LIMIT_S = 300.0
"""Seconds a clip may take before it is given up."""

MEMORY = 4 * 2**30
"""Bytes a worker may take: many times what a clip of minutes needs."""


PR_SET_PDEATHSIG = 1
"""Of Linux's prctl: the signal to get when the parent ends."""

LOOK_EVERY_S = 1.0


def end_with(parent: int) -> None:
    """End this process when the one that started it ends, even by SIGKILL.

    Linux does it at once, whatever Blender is at; a thread that looks does it elsewhere (not on Windows).
    """
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if sys.platform == "win32":
        return
    if os.getppid() != parent:  # it ended before we could ask
        os._exit(1)
    threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_EVERY_S)
    os._exit(1)


@contextlib.contextmanager
def guarded(limit_s: float = LIMIT_S, memory: int = MEMORY) -> Iterator[None]:
    """Bound what a block of work may take in this process.

    Blender's importers are C++ and may hang where no Python exception reaches them: the watchdog's
    thread ends the process from outside the interpreter. More memory than the limit is refused by
    the system (Linux), which Python says as a MemoryError; C++ may end the process on it.

    Parameters
    ----------
    limit_s : float
        Seconds after which the process ends itself.
    memory : int
        Bytes of data the process may hold.
    """
    with Path(os.devnull).open("w") as nowhere, _memory_limit(memory):
        faulthandler.dump_traceback_later(limit_s, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()


@contextlib.contextmanager
def _memory_limit(memory: int) -> Iterator[None]:
    if resource is None:
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_DATA)
    allowed = memory if most == resource.RLIM_INFINITY else min(memory, most)
    resource.setrlimit(resource.RLIMIT_DATA, (allowed, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (before, most))
