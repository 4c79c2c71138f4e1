# SPDX-License-Identifier: GPL-3.0-or-later
"""Clip tasks on the workers of a Dask scheduler, which may be missing, differ from us or die at any moment.

A cluster's worker may be killed for reasons that are no clip's: its job ended, its machine was taken away
(`clip.try_alone`).
"""

from __future__ import annotations

import json
import logging
import operator
import time
from asyncio import CancelledError
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.threads import Spread
from ...core.wording import join_words, restated
from .clip import try_alone, work_in_worker
from .clip_task import ClipTask, Record
from .folder import code_sha256

if TYPE_CHECKING:
    from distributed import Client, Future

ANSWER_S = 20.0
"""Seconds to wait for a scheduler to answer, and for it to have a worker."""

LOOK_EVERY_S = 0.1

AHEAD = 3
"""Clips handed out at a time for each thread of a worker."""


class EngineError(Exception):
    """The workers cannot go on; the message says why and what to do."""


@contextmanager
def connected(scheduler: str) -> Iterator[Client]:
    """A Dask scheduler's client, whose workers run this very version of W2W.

    An EngineError says that it cannot be reached, has no such workers, or went away within the block.
    """
    lacking = "--scheduler needs Dask: run pip install '.[cluster]' in W2W's folder"
    with restated(lacking, ModuleNotFoundError, EngineError):
        from distributed import CancelledError as Lost, Client
        from distributed.comm.core import CommClosedError
    for name in ("distributed", "distributed.client", "asyncio"):  # tracebacks of what we say in a sentence
        logging.getLogger(name).handlers[:] = [logging.NullHandler()]
    silent = f"no Dask scheduler answers at {scheduler}:"
    with restated(silent, (OSError, ValueError, TimeoutError), EngineError):
        client = Client(_address(scheduler), timeout=ANSWER_S)
    gone = (
        f"the Dask scheduler at {scheduler} went away: start it and its workers, and run again; what is "
        "finished is kept"
    )
    with client, restated(gone, (CancelledError, Lost, CommClosedError), EngineError):
        _check_workers(client, scheduler)
        yield client


def _address(scheduler: str) -> str:
    """Address of a scheduler, given itself or by its file, for which Dask would wait for ever."""
    if "://" in scheduler:
        return scheduler
    try:
        return str(json.loads(Path(scheduler).read_text(encoding="utf-8"))["address"])
    except OSError as error:
        raise EngineError(f"--scheduler {scheduler} cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise EngineError(
            f"--scheduler {scheduler} is no scheduler file: give what dask scheduler --scheduler-file wrote, "
            "or an address such as tcp://host:8786"
        ) from error


def _check_workers(client: Client, scheduler: str) -> None:
    idle = f"the Dask scheduler at {scheduler} has no workers: start some with dask worker"
    with restated(idle, TimeoutError, EngineError):
        client.wait_for_workers(1, timeout=ANSWER_S)
    found = client.run(code_sha256, on_error="return")
    killed = [worker for worker, code in found.items() if isinstance(code, OSError)]  # just now
    other = [worker for worker, code in found.items() if worker not in killed and code != code_sha256()]
    if other:
        why = next((f" ({found[worker]})" for worker in other if isinstance(found[worker], Exception)), "")
        raise EngineError(
            f"{len(other)} of {len(found)} Dask workers have another or a broken version of W2W: "
            f"{join_words(other)}{why}: install this one there, and start them again"
        )


def wait_for(client: Client, future: Future) -> Future:
    """Wait until a future is done, while there are workers."""
    return next(_finished(client, iter([future])))


def _finished(client: Client, futures: Iterator[Future]) -> Iterator[Future]:
    """Futures as they are done, some taken ahead for each worker.

    An EngineError says that there are no workers for long.
    """
    from distributed import as_completed

    waiting, seen, workers = as_completed(), time.monotonic(), client.scheduler_info(n_workers=-1)["workers"]
    while True:
        threads = sum(worker["nthreads"] for worker in workers.values())
        waiting.update(list(islice(futures, max(0, AHEAD * max(1, threads) - waiting.count()))))
        if waiting.is_empty():
            return
        batch = waiting.next_batch(block=False)
        yield from batch
        if not batch:
            workers = client.scheduler_info(n_workers=-1)["workers"]
        if batch or workers:
            seen = time.monotonic()
        if time.monotonic() - seen > ANSWER_S:
            raise EngineError(
                "the Dask scheduler has no workers any more: start some and run again; "
                "what is finished is kept"
            )
        time.sleep(0 if batch else LOOK_EVERY_S)


def run_on_cluster(tasks: Sequence[ClipTask], scheduler: str, done: Callable[[Record], None]) -> None:
    """Do all tasks, those at which workers died one by one at the end; the record of each goes to `done`."""
    with connected(scheduler) as client:
        from distributed import KilledWorker

        suspects, task_of = [], {}

        def submitted() -> Iterator[Future]:
            for task in tasks:
                task_of[future := _submit(client, task)] = task
                yield future

        for future in _finished(client, submitted()):
            task = task_of.pop(future)
            try:
                done(future.result())
            except KilledWorker:
                suspects.append(task)
        for task in suspects:
            done(try_alone(task, partial(_once, client)))


def _submit(client: Client, task: ClipTask) -> Future:
    return client.submit(work_in_worker, task, pure=False)


def _once(client: Client, task: ClipTask) -> Record | None:
    """Do a task on a worker that has no other task; None if the worker died."""
    from distributed import KilledWorker

    with suppress(KilledWorker):
        return wait_for(client, _submit(client, task)).result()
    return None


def spread_over(scheduler: str) -> Spread | None:
    """A function that spreads a ranking's patches over a Dask scheduler's workers; None without a scheduler.

    The workers read the features where the run has written them, and send back sums by patch and the
    names given to the windows tested.
    """
    if not scheduler:
        return None

    def spread(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        with connected(scheduler) as client:
            from distributed import KilledWorker

            shared = client.submit(_hold, work, pure=False)  # made again where its worker dies
            futures = [client.submit(operator.call, shared, item, pure=False) for item in items]
            futures.reverse()
            dying = "the cluster's workers keep dying while they rank patches (out of memory?)"
            with restated(dying, KilledWorker, EngineError):
                while futures:  # in order; no result is kept in memory
                    yield wait_for(client, futures.pop()).result()

    return spread


def _hold(work: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return work
