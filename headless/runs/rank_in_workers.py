# SPDX-License-Identifier: GPL-3.0-or-later
"""A ranking's patches tried by worker processes or a cluster, each some patches of all clips."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from typing import Any

from w2w.core.ranking.trial_sums import Spread

from ..stopping import deaf_children
from .cluster import EngineError, connected, wait_for
from .workers import local_executor

MANY_WINDOWS = 1000
"""Windows from which on workers save more time than they take to start."""


def spread_here(workers: int, n_windows: int) -> Spread | None:
    """How a ranking's patches are spread over worker processes; None leaves them to threads of this one.

    A patch's sums take many small steps: threads would spend much of their time waiting for the
    interpreter's lock.
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


def spread_over(scheduler: str) -> Spread | None:
    """How a ranking's patches are spread over a Dask scheduler's workers; None without a scheduler.

    The workers read the features where the run has written them, and send back sums by patch and the
    names given to the windows tested.
    """
    if not scheduler:
        return None

    def spread(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        with connected(scheduler) as client:
            from distributed import KilledWorker

            shared = client.submit(_hold, work, pure=False)  # made again where its worker dies
            futures = [client.submit(_do, shared, item, pure=False) for item in items]
            futures.reverse()
            try:
                while futures:  # in order; no result is kept in memory
                    yield wait_for(client, futures.pop()).result()
            except KilledWorker as error:
                raise EngineError(
                    "the cluster's workers keep dying while they rank patches (out of memory?)"
                ) from error

    return spread


def _hold(work: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return work


def _do(work: Callable[[Any], Any], item: Any) -> Any:
    return work(item)
