# SPDX-License-Identifier: GPL-3.0-or-later
"""Run clip tasks in worker processes, so that a file that crashes or hangs Blender costs only itself.

On one machine the workers are loky's, or background Blenders where this is the Blender program;
on a cluster they are Dask's (see `cluster`). Either way a task is handed out again when its worker died.
"""

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait as wait_for
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import partial
from itertools import islice, zip_longest
from multiprocessing.connection import wait
from typing import Any, TypeAlias, TypeVar

from loky import ProcessPoolExecutor
from loky.backend.context import ctx_loky

from ...core.body.body import Body
from ...core.library.library import Clip
from ...core.motion.motion import Motion
from ...core.motion.source import UnusableMotion, reason_of
from ...core.motion.up import BY_ITSELF, UPSIDE_DOWN
from ...core.reading.formats import Source
from ...core.reading.guard import end_with, timed_out
from ...core.reading.reader import ProgramExecutor, Reader
from ...core.threads import Spread
from ...core.wording import restated
from ..blender import NoBlenderError, inside_blender
from ..stopping import deaf_children, when_stopped
from .clip import PLAIN, get_ready, load_clip, record_death, try_alone, work_in_worker
from .clip_task import ClipTask, Engine, Record
from .cluster import EngineError, run_on_cluster

Result = TypeVar("Result")

Workers: TypeAlias = ProcessPoolExecutor | ProgramExecutor
"""Either takes calls by `submit` and ends by `shutdown(kill_workers=True)`."""

MAX_BREAKS = 5
"""Times in a row that all workers may die with no clip to blame before the run gives up."""

AHEAD = 4
"""Clips handed out at a time for each worker: none waits, and memory stays small whatever the library."""

KILL_S = 5.0
"""Seconds that killed workers are waited for."""


class Crew:
    """Worker processes for all steps of a run: they start with its first work, and anew once some died."""

    def __init__(self) -> None:
        self._executor: Workers | None = None
        self._stack, self._size = ExitStack(), 0

    def workers(self, wanted: int) -> Workers:
        """At least so many workers."""
        if self._executor is None or self._size < wanted:
            self.close()
            self._executor, self._size = self._stack.enter_context(local_executor(wanted)), wanted
        return self._executor

    def get_ready(self, engine: Engine, clips: Sequence[Clip]) -> None:
        """Let workers start, and import what clips need, while this process does other work."""
        if self._executor is None and not engine.scheduler:
            wanted, blender = min(engine.workers, len(clips)), any(clip.needs_blender for clip in clips)
            with deaf_children():
                for _ in range(wanted):
                    self.workers(wanted).submit(get_ready, blender)

    def spread(self, work: Callable[[Any], Result], items: Sequence[Any]) -> Iterator[Result]:
        """Like `map`, by the workers there are; what they die of is done here."""
        futures: list[Future[Result]] = []
        with deaf_children(), suppress(BrokenExecutor):
            futures.extend(self.workers(1).submit(work, item) for item in items)
        for future, item in zip_longest(futures, items):
            found = outcome(future) if future else None
            yield work(item) if found is None else found

    def close(self) -> None:
        """End the workers at once."""
        self._executor = None
        self._stack.close()


def run_tasks(
    tasks: Sequence[ClipTask],
    workers: int,
    scheduler: str,
    done: Callable[[Record], None],
    crew: Crew,
) -> None:
    """Do all tasks; the record of each goes to `done` as it comes.

    A Dask scheduler's workers must see the library and the output folder at the same paths. Without one,
    the crew does the tasks. An EngineError says that the scheduler cannot be reached, or that workers die
    again and again.
    """
    if scheduler:
        run_on_cluster(tasks, scheduler, done)
    else:
        _on_this_machine(tasks, workers, done, crew)


def _on_this_machine(
    tasks: Sequence[ClipTask], workers: int, done: Callable[[Record], None], crew: Crew
) -> None:
    waiting = {task.clip.name: task for task in tasks}
    breaks = 0

    def came(record: Record) -> None:
        del waiting[record["clip"]]
        done(record)

    while _collect(crew, workers, [*waiting.values()], came):
        suspects = [task for task in waiting.values() if task.marker.exists()]
        for task in suspects:
            came(record_death(task) if timed_out(task.marker) else try_alone(task, _once))
        breaks = 0 if suspects else breaks + 1
        if breaks >= MAX_BREAKS:
            raise EngineError(
                "worker processes keep dying before they begin (out of memory?): try fewer --workers"
            )


def run_alone(work: Callable[..., Result], *args: object) -> Result | None:
    """Call a function in a worker process of its own; None if the worker dies of it."""
    with local_executor(1) as executor:
        with deaf_children():
            future = executor.submit(work, *args)
        return outcome(future)


def outcome(future: Future[Result]) -> Result | None:
    """What a call in a worker gives; None if the worker died of it."""
    return None if isinstance(future.exception(), BrokenExecutor) else future.result()


def _once(task: ClipTask) -> Record | None:
    """Do a task in a worker of its own; None if the worker died."""
    return run_alone(work_in_worker, task)


def _collect(crew: Crew, workers: int, tasks: Sequence[ClipTask], done: Callable[[Record], None]) -> bool:
    """Hand out tasks and gather records; True if the workers died before all were done."""
    if not tasks:
        return False
    queue, pending = iter(tasks), set[Future[Record]]()
    executor = crew.workers(min(workers, len(tasks)))
    try:
        while True:
            with deaf_children():
                new = islice(queue, AHEAD * workers - len(pending))
                pending |= {executor.submit(work_in_worker, task) for task in new}
            if not pending:
                return False
            ended, pending = wait_for(pending, return_when=FIRST_COMPLETED)
            for future in ended:
                done(future.result())
    except BrokenExecutor:
        crew.close()  # those that live would go on with what is waiting
        return True


@contextmanager
def local_executor(workers: int, idle_s: int = 60) -> Iterator[Workers]:
    """Worker processes here, which end with the block, when this process is stopped, or without work."""
    if inside_blender():
        executor: Workers = ProgramExecutor(workers)
        kill = executor.kill
    else:
        with deaf_children():
            executor = ProcessPoolExecutor(
                workers,
                context=ctx_loky,  # by name it may be another copy's, with trackers of its own
                timeout=idle_s,
                initializer=end_with,
                initargs=(os.getpid(),),
            )
        kill = partial(_kill, executor)
    with when_stopped(kill):
        try:
            yield executor
        finally:
            executor.shutdown(kill_workers=True)


def _kill(executor: ProcessPoolExecutor) -> None:
    """End an executor's workers at once, and wait until they are gone: the folder's lock goes next."""
    workers = list((executor._processes or {}).values())
    for worker in workers:
        with suppress(OSError):
            os.kill(worker.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
    until = time.monotonic() + KILL_S
    for worker in workers:
        wait([worker.sentinel], max(0.0, until - time.monotonic()))


LoadedClip = tuple[Source, Motion, dict[str, Any]]


def load_alone(clip: Clip, body: Body, how: Engine = PLAIN, reader: Reader | None = None) -> LoadedClip:
    """Like `load_clip`, in a worker process, of the `reader` or its own, whatever the file does to it.

    Without the `ups` of a library the clip is by itself, and refused if it is upside down.
    """
    work = partial(load_clip, clip, body, how)
    try:
        with nullcontext(reader) if reader else Reader() as used:
            found = used.call(clip.path, work)
    except (NoBlenderError, UnusableMotion):
        raise
    except Exception as error:
        raise UnusableMotion(reason_of(error)) from error
    if how.ups is BY_ITSELF and "head_down" in found[2]:
        raise UnusableMotion(UPSIDE_DOWN)
    return found


def spread_here(workers: int, crew: Crew) -> Spread | None:
    """A function that spreads a ranking's patches over a crew; None, for one worker, leaves them here.

    A patch's sums take many small steps: threads would spend much of their time waiting for the
    interpreter's lock.
    """
    if workers < 2:
        return None

    def spread(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        dying = "worker processes die while they rank patches (out of memory?): try fewer --workers"
        with restated(dying, BrokenExecutor, EngineError):
            executor = crew.workers(workers)
            with deaf_children():
                futures = [executor.submit(work, item) for item in items]
            for future in futures:
                yield future.result()

    return spread
