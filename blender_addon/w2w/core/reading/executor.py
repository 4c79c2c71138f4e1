# SPDX-License-Identifier: GPL-3.0-or-later
"""Worker processes that may die: of this Python, or of the Blender program, whose Python has no `bpy`."""

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
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import cloudpickle

from ..body.body import PACKAGE
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
