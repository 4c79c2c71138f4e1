# SPDX-License-Identifier: GPL-3.0-or-later
"""A ranking's patches tried by the workers of a cluster, each some patches of all clips."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from w2w.core.ranking.trial_sums import Spread

from .cluster import EngineError, connected, wait_for

if TYPE_CHECKING:
    from distributed import Client


def spread_over(scheduler: str) -> Spread | None:
    """Who tries patches for a ranking: the workers of a Dask scheduler; None, this process, without one.

    The workers read the features where the run has written them; what comes back is sums by patch, and the
    names given to the windows tested.

    Parameters
    ----------
    scheduler : str
        Address of a Dask scheduler, or a scheduler file; empty for none.
    """
    if not scheduler:
        return None

    def spread(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        with connected(scheduler) as client:
            from distributed import KilledWorker

            shared = client.submit(_hold, work, pure=False)  # made again where its worker dies
            futures = [client.submit(_do, shared, item, pure=False) for item in items]
            try:
                yield from _results(client, futures)
            except KilledWorker as error:
                raise EngineError(
                    "the cluster's workers keep dying while they rank patches (out of memory?)"
                ) from error

    return spread


def _hold(work: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return work


def _do(work: Callable[[Any], Any], item: Any) -> Any:
    return work(item)


def _results(client: Client, futures: list[Any]) -> Iterable[Any]:
    """Results in order, none of which is held on to."""
    futures.reverse()
    while futures:
        yield wait_for(client, futures.pop()).result()
