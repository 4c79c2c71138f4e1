# SPDX-License-Identifier: GPL-3.0-or-later
"""Stop at Ctrl-C, SIGTERM and SIGHUP: the workers first, then a sentence, then this process.

Nothing is unwound: an exception out of a signal handler is lost where it meets a destructor or a
callback, and comes out as a traceback elsewhere. What is on disk survives a kill at any moment anyway.
It imports little, so that it is ready before everything that takes a second.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

from .blender import inside_blender

STOPPED = "Stopped. What is finished is kept: the same command goes on from here."
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
SHOW_CURSOR = "\x1b[?25h"
"""A progress bar has hidden it."""

SAY_S = 1.0
"""Seconds that a last word may take: nobody may be reading."""

QUIET_TRACKERS = "ignore:resource_tracker"


@dataclass
class _Stop:
    """The handler of all signals, and what is to be done before this process ends."""

    process: int = 0
    screen: int = -1
    works: list[Callable[[], None]] = field(default_factory=list)
    line: Callable[[int], str] | None = None

    def __call__(self, number: int, _frame: object) -> None:
        code = 128 + number
        ignore_signals()
        if os.getpid() != self.process:  # forked off
            os._exit(code)
        for work in reversed(self.works):
            with suppress(Exception):
                work()
        _try(sys.stdout.flush)
        said = f"{SHOW_CURSOR if os.isatty(self.screen) else ''}\n{STOPPED}\n"
        text = said if self.line is None else self.line(code) + "\n"
        _try(lambda: os.write(self.screen, text.encode()))
        os._exit(code)


def _try(work: Callable[[], object]) -> None:
    """Wait at most a second for a call: the terminal may be gone, a pipe full, a write half done."""

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
    """Ignore signals while the process does its last things."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def say_for_machines(line: Callable[[int], str]) -> None:
    """Say "stopped" by a line made from the exit code instead of a sentence."""
    _STOP.line = line


@contextmanager
def when_stopped(work: Callable[[], None]) -> Iterator[None]:
    """Call a function if a signal ends the process during the block."""
    _STOP.works.append(work)
    try:
        yield
    finally:
        _STOP.works.remove(work)


def always_when_stopped(work: Callable[[], None]) -> None:
    """Call a function, after all others, whenever a signal ends the process."""
    _STOP.works.insert(0, work)


@contextmanager
def deaf_children() -> Iterator[None]:
    """Start workers of loky that a Ctrl-C in the terminal does not reach: this process ends them.

    Workers of the Blender program have a session of their own and need nothing.
    """
    if inside_blender():
        yield
        return
    _start_trackers()
    with _held_back("SIGINT"):
        yield


def _start_trackers() -> None:
    """Start the trackers of semaphores, loky's and Python's own, which free those of a killed run.

    They do that without a warning, are deaf to a terminal that closes, and start before SIGINT is held back:
    starting one ends by letting it through.
    """
    from multiprocessing import resource_tracker as pythons

    from loky.backend import resource_tracker as lokys

    others = os.environ.get("PYTHONWARNINGS", "")
    if QUIET_TRACKERS not in others:
        os.environ["PYTHONWARNINGS"] = f"{others},{QUIET_TRACKERS}".lstrip(",")
    with _held_back("SIGHUP"):
        lokys.ensure_running()
        if sys.platform != "win32":
            pythons.ensure_running()


@contextmanager
def _held_back(name: str) -> Iterator[None]:
    """Block a signal, also for the processes that are started meanwhile; Windows cannot."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [getattr(signal, name)])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
