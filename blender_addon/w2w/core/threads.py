# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads for numerical work on independent parts of one array."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import Any, TypeVar

import scipy.linalg  # noqa: F401 - its matrix library must be there to be found
from threadpoolctl import OpenBLASController, ThreadpoolController

Part = TypeVar("Part")
Result = TypeVar("Result")

Spread = Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]]
"""Like `map`, but may run the calls elsewhere; results keep the order of the items."""

_most = 0
_limits: list[Any] = []  # of the blocks that are open: what the first limits, and None of each further one
_limiting = Lock()


def for_each(work: Callable[[Part], Result], parts: Sequence[Part]) -> list[Result]:
    """Results of `work` on every part, in all threads that this process may use.

    The matrix library is kept to one thread then: two sets of threads would fight over the cores.
    """
    with unthreaded_products():
        if len(parts) == 1 or n_threads() == 1:
            return [work(part) for part in parts]
        with ThreadPoolExecutor(n_threads()) as pool:
            return list(pool.map(work, parts))


def chunks(count: int, size: int) -> list[slice]:
    """Ranges of this size, the last one shorter, that make up a whole."""
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


@contextmanager
def unthreaded_products() -> Iterator[None]:
    """Keep the matrix libraries of NumPy and SciPy to one thread: sums split over threads round otherwise.

    Of blocks that overlap in several threads the last to end brings the libraries' threads back.
    """
    with _limiting:
        _limits.append(None if _limits else _libraries().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _limiting:
            if limit := _limits.pop():
                # else only the thread that limited them could set them, now and later
                OpenBLASController.clear_controlling_thread(force=True)
                limit.restore_original_limits()
                OpenBLASController.clear_controlling_thread(force=True)


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    """The libraries loaded at the first call: finding them is slow."""
    return ThreadpoolController()


def use_threads(most: int) -> None:
    """Limit this process to `most` threads for numerical work; 0 removes the limit."""
    global _most
    _most = most


def n_threads() -> int:
    """The limit of `use_threads` or of ``OMP_NUM_THREADS``, which process pools set, else usable cores."""
    if _most:
        return _most
    allowed = os.environ.get("OMP_NUM_THREADS", "")
    if allowed.isdigit() and int(allowed) > 0:
        return int(allowed)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
