# SPDX-License-Identifier: GPL-3.0-or-later
"""Worker processes that take part in this one's numerical work."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from queue import SimpleQueue
from typing import Any

from ..threads import Spread, n_threads
from .reader import ProgramExecutor

MOST = 3
"""Workers at most: each is a Blender or a Python, of some hundred MB."""


@contextmanager
def helped() -> Iterator[Spread]:
    """A function that spreads calls over a thread here and workers, which start with the first ones.

    Where calls take many small steps, threads would spend much of their time waiting for the interpreter's
    lock. What a worker dies of is done here.
    """
    count = min(n_threads() - 1, MOST)
    executor, pool = ProgramExecutor(count), ThreadPoolExecutor(count + 1)
    free = SimpleQueue[bool]()  # whether it is a worker
    for place in range(count + 1):
        free.put(place > 0)

    def do(work: Callable[[Any], Any], item: Any) -> Any:
        is_worker = free.get()
        try:
            return executor.submit(work, item).result() if is_worker else work(item)
        except BrokenExecutor:
            return work(item)
        finally:
            free.put(is_worker)

    def spread(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        return pool.map(partial(do, work), items)

    try:
        yield spread
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        executor.shutdown(kill_workers=True)
