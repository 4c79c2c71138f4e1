# SPDX-License-Identifier: GPL-3.0-or-later
"""Stop at Ctrl-C, SIGTERM and SIGHUP: the workers first, then a sentence, then this process.

Nothing is unwound: an exception out of a signal handler is lost where it meets a destructor or a
callback, and comes out as a traceback elsewhere. What is on disk stands a kill at any moment anyway.
Light to import, so that it can stand before everything that takes a second.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from .blender import inside_blender

STOPPED = "Stopped. What is finished is kept: the same command goes on from here."
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
SHOW_CURSOR = "\x1b[?25h"
"""A progress bar has hidden it."""

SAY_S = 1.0
"""Seconds that a last word may take: nobody may be reading."""


class _Stop:
    """What is to be done before this process ends."""

    def __init__(self) -> None:
        self.process = 0
        self.screen = -1
        self.works: list[Callable[[], None]] = []
        self.line: Callable[[int], str] | None = None

    def __call__(self, number: int, _frame: object) -> None:
        code = 128 + number
        ignore_signals()
        if os.getpid() != self.process:  # forked off
            os._exit(code)
        for work in reversed(self.works):
            with suppress(Exception):
                work()
        self.say(code)
        os._exit(code)

    def say(self, code: int) -> None:
        """Say it on the screen, or for machines."""
        _try(sys.stdout.flush)
        if self.line is not None:
            text = self.line(code) + "\n"
        else:
            text = f"{SHOW_CURSOR if os.isatty(self.screen) else ''}\n{STOPPED}\n"
        _try(lambda: os.write(self.screen, text.encode()))


def _try(work: Callable[[], object]) -> None:
    """Do it within a second, if it can be done: the terminal may be gone, a pipe full, a write half done."""

    def tried() -> None:
        with suppress(Exception):
            work()

    thread = threading.Thread(target=tried, daemon=True)
    thread.start()
    thread.join(SAY_S)


_STOP = _Stop()


def stop_on_signals() -> None:
    """Let signals end this process; those that it was started to ignore (nohup) stay ignored."""
    if _STOP.process == os.getpid():
        return
    with suppress(OSError):
        _STOP.screen = os.dup(1)  # while Blender works, 1 leads nowhere
    _STOP.process = os.getpid()
    for number in SIGNALS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _STOP)


def ignore_signals() -> None:
    """Let no signal disturb what little is left to do."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def say_for_machines(line: Callable[[int], str]) -> None:
    """Say it by a line made from the exit code instead."""
    _STOP.line = line


@contextmanager
def when_stopped(work: Callable[[], None]) -> Iterator[None]:
    """Have something done if a signal ends the process during the block."""
    _STOP.works.append(work)
    try:
        yield
    finally:
        _STOP.works.remove(work)


def always_when_stopped(work: Callable[[], None]) -> None:
    """Have something done, last of all, whenever a signal ends the process."""
    _STOP.works.insert(0, work)


@contextmanager
def deaf_children() -> Iterator[None]:
    """Start workers of loky that a Ctrl-C in the terminal does not reach: this process ends them.

    Workers of the Blender program stand in a session of their own and need nothing.
    """
    if inside_blender():
        yield
        return
    _start_trackers()
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_trackers() -> None:
    """Start the trackers of semaphores, loky's and Python's own, which free those of a killed run.

    Without their warning of that, deaf to a terminal that closes, and before SIGINT is blocked:
    starting one ends by unblocking it.
    """
    from multiprocessing import resource_tracker as pythons

    from loky.backend import resource_tracker

    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, (before, "ignore:resource_tracker")))
    try:
        if sys.platform == "win32":
            resource_tracker.ensure_running()
            return
        heard = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGHUP])  # which a child inherits
        try:
            resource_tracker.ensure_running()
            pythons.ensure_running()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, heard)
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before
