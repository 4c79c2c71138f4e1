# SPDX-License-Identifier: GPL-3.0-or-later
"""A ranking's patches tried by worker processes, each some patches of all clips."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from typing import Any

from w2w.core.ranking.trial_sums import Spread

from ..stopping import deaf_children
from .cluster import EngineError
from .workers import local_executor

MANY_WINDOWS = 1000
"""Windows from which on workers save more time than they take to start."""


def spread_here(workers: int, n_windows: int) -> Spread | None:
    """Who tries patches for a ranking of so many windows: worker processes; None, threads of this process.

    A patch's sums are so many small steps that threads spend much of their time handing each other the
    interpreter's lock.

    Parameters
    ----------
    workers : int
        Processes at most.
    n_windows : int
    """
    if workers < 2 or n_windows < MANY_WINDOWS:
        return None

    def spread(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        with local_executor(min(workers, len(items))) as executor:
            with deaf_children():
                futures = [executor.submit(work, item) for item in items]
            try:
                for future in futures:
                    yield future.result()
            except BrokenExecutor as error:
                raise EngineError(
                    "worker processes die while they rank patches (out of memory?): try fewer --workers"
                ) from error

    return spread
