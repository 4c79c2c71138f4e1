# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from strangers, read where they can do no harm, and the worker processes for it, which may die."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import secrets
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, ParamSpec, Self, TypeVar
from zipfile import ZipFile, is_zipfile

import cloudpickle

from ..body.body import PACKAGE
from ..files import DAMAGED, stamp
from ..motion.source import UnusableMotion, unreadable
from ..threads import unthreaded_products
from . import guard
from .formats import RISKY
from .guard import end_with
from .worker import GONE, send

P = ParamSpec("P")
T = TypeVar("T")

WORKER = Path(__file__).with_name("worker.py")
OPTIONS = (
    "--background", "--factory-startup", "--offline-mode", "--disable-crash-handler",
    "--python-exit-code", "1", "--python",
)  # fmt: skip
"""A worker is the same whatever the user's preferences are, and leaves no crash report behind."""

KILL_S = 5.0
"""Seconds to wait for killed workers."""


class ProgramExecutor:
    """Does calls in processes of a program, as loky's executor does in Python processes.

    Workers are started when there is work, by the command `program`, which runs a Python file: this Blender
    in the background by default, or this Python. When one dies, all calls that are not done fail with
    BrokenProcessPool. A worker whose parent dies, by `kill -9` too, finds its standard input closed and ends.
    """

    def __init__(self, workers: int, program: list[str] | None = None) -> None:
        self._program = program or _this_program()
        self._waiting = queue.SimpleQueue[tuple[Future[Any], Callable[[], object]] | None]()
        self._broken = threading.Event()
        self._lock = threading.Lock()
        self._closed = False
        self._processes: list[subprocess.Popen] = []
        self._threads = [threading.Thread(target=self._serve, daemon=True) for _ in range(workers)]
        for thread in self._threads:
            thread.start()

    def submit(self, work: Callable[P, T], /, *arguments: P.args, **named: P.kwargs) -> Future[T]:
        future: Future[T] = Future()
        with self._lock:
            if self._closed:
                raise RuntimeError("cannot submit after shutdown")
            self._waiting.put((future, partial(work, *arguments, **named)))
        return future

    def shutdown(self, *, kill_workers: bool = False) -> None:
        """End the workers when they have done what is waiting; with `kill_workers`, at once."""
        with self._lock:
            self._closed = True
            if kill_workers:
                self._broken.set()
                for process in self._processes:
                    process.kill()
        for _ in self._threads:
            self._waiting.put(None)
        for thread in self._threads:
            thread.join()

    def kill(self) -> None:
        """End the workers at once and wait until they are gone; takes no lock, so a signal may call it."""
        self._broken.set()
        for process in self._processes:
            process.kill()
        for process in self._processes:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(KILL_S)

    def _serve(self) -> None:
        """Pass calls on to one worker until there are no more."""
        if hasattr(signal, "pthread_sigmask"):  # Blender dies of a write to a dead worker, as Python does not
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
        worker = None
        try:
            while (item := self._waiting.get()) is not None:
                future, work = item
                if not future.set_running_or_notify_cancel():
                    continue
                try:
                    call = cloudpickle.dumps(work)
                    worker = worker or self._start()
                    done, value = worker.ask(call)
                except (*GONE, BrokenProcessPool):
                    self._broken.set()
                    future.set_exception(BrokenProcessPool("a worker died"))
                except Exception as error:  # the call cannot be pickled
                    future.set_exception(error)
                else:
                    future.set_result(value) if done else future.set_exception(value)
        finally:
            if worker is not None:
                worker.end()

    def _start(self) -> _Worker:
        """A fresh worker that waits for calls; a BrokenProcessPool where one died or this cannot start."""
        with self._lock:
            if self._broken.is_set():
                raise BrokenProcessPool("a worker died")
            worker = _Worker(self._program)
            self._processes.append(worker.process)
        try:
            worker.begin()
        except BaseException:
            worker.end()
            raise
        return worker


def _this_program() -> list[str]:
    blender = sys.modules["bpy"].app.binary_path if sys.modules.get("bpy") else ""
    return [blender, *OPTIONS] if blender else [sys.executable, "-P"]


class _Worker:
    """One worker process and the pipes to it."""

    def __init__(self, program: list[str]) -> None:
        self._mark = secrets.token_hex(16)
        self._session_folder = ""
        process = subprocess.Popen(
            [*program, str(WORKER), "--", self._mark],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=WORKER.parent,  # as it starts, Blender runs libraries from the current directory's `plugins`
            start_new_session=True,  # Ctrl-C is for the parent, which ends its workers itself
        )
        assert process.stdin
        assert process.stdout
        self.process, self._calls, self._results = process, process.stdin, process.stdout

    def begin(self) -> None:
        """Wait until it listens, past all that Blender prints as it starts."""
        while (line := self._results.readline()).strip() != self._mark.encode():
            if not line:
                raise BrokenProcessPool("a worker could not start")
        self._session_folder = pickle.load(self._results)  # noqa: S301 - from our own worker
        # where the tree itself is the extension, `w2w` is not on the path
        send(self._calls, (Path.cwd(), [*sys.path, str(PACKAGE.parent)]))
        self.ask(cloudpickle.dumps(partial(end_with, os.getpid())))  # a reader may leave `_receive` no turn

    def ask(self, call: bytes) -> tuple[bool, Any]:
        """Whether a call succeeded, and what it returned or raised."""
        send(self._calls, call)
        return pickle.loads(pickle.load(self._results))  # noqa: S301 - from our own worker

    def end(self) -> None:
        """End the process, and remove the folder that a killed Blender leaves."""
        self.process.kill()
        with contextlib.suppress(OSError):
            self._calls.close()
        self._results.close()
        self.process.wait()
        if self._session_folder:
            shutil.rmtree(self._session_folder, ignore_errors=True)


HARMLESS_BYTES = 2**24
"""Bytes, unpacked, up to which other files are read in this process: Python's readers take a few times as
much, and a worker a second to start."""


LOOK_SHARE = 10
"""Part of the time limit that a first look at a file may take.

At 64 MB, the most that is looked at, the slowest kinds took 8 s of 30 on a busy machine.
"""


class Death(NamedTuple):
    """Why a file is not read again, which killed or outlasted its reader, and how it looked before."""

    reason: str
    stamp: list[int]


class Reader:
    """Reads files in a worker process, which starts with the first one, and anew where one killed it.

    The worker ends with the block, or with this process; `deadly` has the files that killed one, and `lost_s`
    is the time that went into them.
    """

    def __init__(
        self,
        limit_s: float | None = None,
        memory: int | None = None,
        deadly: Mapping[Path, Death] | None = None,
    ) -> None:
        self.limit_s, self.memory = limit_s or guard.LIMIT_S, memory or guard.MEMORY
        self._executor: ProgramExecutor | None = None
        self.deadly, self.lost_s = dict(deadly or {}), 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def read(self, path: Path, work: Callable[[], T]) -> T:
        """Call a function that reads a file: here if that is harmless, else in the worker."""
        return work() if is_harmless(path) else self.call(path, work)

    @contextlib.contextmanager
    def looking(self) -> Iterator[None]:
        """Read in less time, for a first look at many files."""
        limit_s, self.limit_s = self.limit_s, self.limit_s / LOOK_SHARE
        try:
            yield
        finally:
            self.limit_s = limit_s

    def call(self, path: Path, work: Callable[[], T]) -> T:
        """Call a function that reads a file in the worker, but not again where it killed or outlasted it.

        Raises UnusableMotion then, or if it takes more memory, or the file cannot be read.
        """
        if path in self.deadly:
            raise UnusableMotion(self.deadly[path].reason)
        looked, began = stamp(path), time.monotonic()
        if self._executor is None:
            self._executor = ProgramExecutor(1)
        try:
            return self._executor.submit(bounded, self.limit_s, self.memory, work).result()
        except BrokenProcessPool:
            self._end()
            self.lost_s += time.monotonic() - began
            reason = (
                f"the program that reads it crashed, or took longer than {self.limit_s:g} s or more than "
                f"{_gib(self.memory)}: it is damaged, or far too long"
            )
            self.deadly[path] = Death(reason, looked)
            raise UnusableMotion(reason) from None

    def _end(self) -> None:
        if self._executor is not None:
            self._executor.shutdown(kill_workers=True)
            self._executor = None


def bounded(limit_s: float, memory: int, work: Callable[[], T]) -> T:
    """Call a function within limits; UnusableMotion if it needs more memory, or its file cannot be read."""
    with guard.guarded(limit_s, memory), unthreaded_products():
        try:
            return work()
        except MemoryError:
            raise UnusableMotion(f"it needs more than {_gib(memory)} of memory") from None
        except OSError as error:
            raise UnusableMotion(unreadable(error)) from error


def _gib(memory: int) -> str:
    return f"{min(memory, guard.allowed_memory()) / 2**30:.1f} GiB"


def is_harmless(path: Path) -> bool:
    """Whether a file is small and of a kind that Python alone reads; one that cannot be read is, too."""
    if path.suffix.lower() in RISKY:
        return False
    try:
        size = path.stat().st_size if path.is_file() else 0
        if 0 < size <= HARMLESS_BYTES and is_zipfile(path):
            with ZipFile(path) as archive:
                size = sum(member.file_size for member in archive.infolist())
    except (OSError, ValueError, *DAMAGED):
        return True
    return size <= HARMLESS_BYTES
