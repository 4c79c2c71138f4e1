# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from strangers, read where they can do no harm."""

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, Self, TypeVar
from zipfile import ZipFile, is_zipfile

from ..files import DAMAGED, stamp
from ..motion.source import UnusableMotion, unreadable
from . import guard
from .executor import ProgramExecutor
from .formats import RISKY

T = TypeVar("T")

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

    @contextmanager
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
    with guard.guarded(limit_s, memory):
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
