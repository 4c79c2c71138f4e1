# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of the web app: runs as processes of the command line, and workers that open files."""

import asyncio
import json
import os
import shutil
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TypeVar

from ..core.reading.formats import is_motion
from ..headless.runs.monitor import read_state
from ..headless.runs.workers import Workers, local_executor
from ..headless.stopping import deaf_children
from .clips import ARRIVING
from .request import EVENTS, INPUT, REQUEST
from .study import ID, Study
from .uploads import DISK_FULL, NO_DISK, RefusedError, judge

Result = TypeVar("Result")

COMMAND = (
    "import sys; from w2w.core.reading.guard import end_with; end_with(int(sys.argv.pop(1))); "
    "from w2w.headless.start import main; main()"
)
"""The command line as a process that ends with the server."""

PATIENCE_S = 10.0
"""Seconds that a run gets to stop by itself."""

REMEMBERED_S = 900
"""Seconds without a question after which a study that is chosen from is forgotten."""

DAY_S = 86400

LARGE = 5_000_000
"""Bytes from which on a file waits for other large ones, so that small ones never do."""

CRASHED = "it is damaged, or far too long: the program that reads it crashed"

KILLED = "The run was killed: there may be too little memory. Run again to go on."


class Reader:
    """A worker process that opens files, or chooses; a new one where it died."""

    def __init__(self, idle_s: int = 60) -> None:
        self._stack, self._one, self._idle_s = ExitStack(), asyncio.Lock(), idle_s
        self._executor: Workers | None = None

    async def ask(self, work: Callable[..., Result], *args: object) -> Result | None:
        """Call a function in the worker; None if it died of it."""
        async with self._one:
            return await asyncio.to_thread(self._ask, work, *args)

    def _ask(self, work: Callable[..., Result], *args: object) -> Result | None:
        if self._executor is None:
            self._executor = self._stack.enter_context(local_executor(1, self._idle_s))
        try:
            with deaf_children():
                future = self._executor.submit(work, *args)
            return future.result()
        except BrokenExecutor:
            self.close()
            return None

    def close(self) -> None:
        """End the worker."""
        self._stack.close()
        self._executor = None


class Readers:
    """A worker for small files and one for large ones: nobody waits for somebody else's long file."""

    def __init__(self) -> None:
        self.small, self.large = Reader(), Reader()

    def of(self, path: Path) -> Reader:
        """The reader for a file."""
        with suppress(OSError):
            return self.large if path.stat().st_size > LARGE else self.small
        return self.small

    def close(self) -> None:
        """End both workers."""
        self.small.close()
        self.large.close()


class Queue:
    """Places for runs: a free one goes to whose runs had the fewest so far, then to who waited longest."""

    def __init__(self, places: int) -> None:
        self.free, self.places, self._waiting = places, places, dict[str, tuple[str, asyncio.Future[None]]]()
        self._served = Counter[str]()

    async def wait(self, study: Study) -> None:
        """Wait for a place, which `leave` gives back."""
        place = asyncio.get_running_loop().create_future()
        self._waiting[study.id] = study.folder.parent.name, place
        self._serve()
        try:
            await place
        except asyncio.CancelledError:
            if place.done() and not place.cancelled():
                self.leave()
            raise
        finally:
            self._waiting.pop(study.id, None)
            self._serve()

    def leave(self) -> None:
        """Give a place back."""
        self.free += 1
        self._serve()

    def before(self, study: Study) -> int:
        """How many runs that wait have their turn before a study's."""
        order = [name for name, _ in self._order()]
        return order.index(study.id) if study.id in order else 0

    def _order(self) -> list[tuple[str, asyncio.Future[None]]]:
        turns, ordered = Counter(self._served), []
        for name, (owner, place) in self._waiting.items():
            if not place.done():
                ordered.append((turns[owner], name, place))
                turns[owner] += 1
        ordered.sort(key=lambda one: one[0])
        return [(name, place) for _, name, place in ordered]

    def _serve(self) -> None:
        while self.free and (order := self._order()):
            name, place = order[0]
            self._served[self._waiting[name][0]] += 1
            self.free -= 1
            place.set_result(None)
        if not self._waiting and self.free == self.places:
            self._served.clear()


class Work:
    """What is to be done in a data folder: files to judge, runs to do, old studies to delete."""

    def __init__(self, data: Path, at_once: int, scheduler: str, keep_days: float) -> None:
        self.data, self.scheduler, self.keep_s = data, scheduler, keep_days * DAY_S
        self.readers, self.unpackers = Readers(), Readers()
        self.chooser, self.tryer = Reader(REMEMBERED_S), Reader()
        self.running, self.queue = set[str](), Queue(at_once)
        self._workers = max(1, (os.cpu_count() or 1) // at_once)
        self._runs: dict[str, asyncio.Task[None]] = {}
        self._failed: dict[str, str] = {}
        self._judging: dict[str, asyncio.Task[None]] = {}
        self._keeper: asyncio.Task[None] | None = None
        self._preparing: asyncio.Task[None] | None = None
        self._looked = time.monotonic()
        self.clip_s = 0.0  # seconds that a clip took in the last run that ended here; 0 before any

    def start(self) -> None:
        """Go on where an earlier server was; what it had not finished to receive is removed."""
        for path in self.data.glob(f"*/*/{ARRIVING}*"):
            shutil.rmtree(path, ignore_errors=True)
        waiting = []
        for study in self.studies():
            with suppress(RefusedError):
                waiting += [(study.request()["asked"], study)] if study.waits else []
        for _, study in sorted(waiting, key=lambda one: one[0]):
            self.run(study)
        self._keeper = asyncio.create_task(self._delete_old())

    async def stop(self) -> None:
        """End all work; runs go on with the next server."""
        others = [task for task in (self._keeper, self._preparing) if task]
        tasks = [*self._runs.values(), *self._judging.values(), *others]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for reader in (self.readers, self.unpackers, self.chooser, self.tryer):
            reader.close()

    def studies(self) -> Iterator[Study]:
        """All studies of all owners."""
        for path in self.data.glob(f"*/*/{REQUEST}"):
            if ID.fullmatch(path.parent.name):
                yield Study(path.parent)

    def failed(self, study: Study) -> str:
        """Why a run that could not even write it down did not begin; "" if that is not so."""
        return self._failed.get(study.id, "")

    def waits(self, study: Study) -> bool:
        """Whether a study's run is on its way."""
        return study.waits and not self.failed(study)

    def run(self, study: Study) -> None:
        """Do a study's run as soon as there is a place; it judges all files itself."""
        if task := self._judging.get(study.id):
            task.cancel()
        self._failed.pop(study.id, None)
        task = asyncio.create_task(self._after(self._runs.get(study.id), study))
        self._runs[study.id] = task
        task.add_done_callback(lambda task: self._runs.get(study.id) is task and self._runs.pop(study.id))

    async def _after(self, before: asyncio.Task[None] | None, study: Study) -> None:
        """Run once the study's process before, which has said its last word, is gone."""
        if before:
            await asyncio.wait([before])
        await self._run(study)

    async def cancel(self, study: Study) -> None:
        """Stop a study's run, or take it from the queue; what is finished is kept."""
        with suppress(RefusedError):
            study.change(asked=None)
        if task := self._runs.get(study.id):
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    async def delete(self, study: Study) -> None:
        """Remove a study with all that it holds."""
        await self.cancel(study)
        if task := self._judging.get(study.id):
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
        await asyncio.to_thread(shutil.rmtree, study.folder, ignore_errors=True)

    async def _run(self, study: Study) -> None:
        asked = study.request()["asked"]
        await self.queue.wait(study)
        try:
            await self._process(study)
            problem = KILLED  # if it could not say what happened
        except OSError as error:
            problem = (
                f"The run could not be started: {NO_DISK if error.errno in DISK_FULL else error.strerror}."
            )
        except RefusedError as error:
            problem = f"The run could not be started: {error}."
        finally:
            self.queue.leave()
        with suppress(OSError, ValueError, TypeError):
            state = read_state(study.results)
            self.clip_s = (
                state.spent / state.clips if state.clips and state.step == "finished" else self.clip_s
            )
        if study.end() is None and study.request()["asked"] == asked:
            ended = {"event": "finished", "exit_code": 1, "problem": problem}
            try:
                with (study.folder / EVENTS).open("a", encoding="utf-8") as stream:
                    stream.write("\n" + json.dumps(ended) + "\n")
            except OSError:
                self._failed[study.id] = problem

    async def _process(self, study: Study) -> None:
        words = study.command(self._workers, self.scheduler)
        with (study.folder / EVENTS).open("wb") as events:
            process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-P", "-c", COMMAND, str(os.getpid()), *words),
                stdin=asyncio.subprocess.DEVNULL, stdout=events, stderr=asyncio.subprocess.DEVNULL,
                start_new_session=True,
            )  # fmt: skip
        self.running.add(study.id)
        try:
            await process.wait()
        except asyncio.CancelledError:
            with suppress(ProcessLookupError):
                process.terminate()
                await asyncio.wait_for(process.wait(), PATIENCE_S)
            raise
        finally:
            self.running.discard(study.id)
            if process.returncode is None:
                process.kill()

    def prepare(self, out: Path, get_ready: Callable[[Path], None]) -> None:
        """Get ready to choose in a study while nobody waits for it."""

        async def ready() -> None:
            with suppress(ValueError, OSError):
                await self.chooser.ask(get_ready, out)

        if self._preparing is None or self._preparing.done():
            self._preparing = asyncio.create_task(ready())

    def judge(self, study: Study) -> None:
        """Judge all files of a study that are not judged yet."""
        if study.id not in self._judging:
            self._judging[study.id] = task = asyncio.create_task(self._judge(study))
            task.add_done_callback(lambda _: self._judging.pop(study.id, None))

    async def _judge(self, study: Study) -> None:
        files, rates = None, dict[str, float]()
        while file := _unjudged(study):
            if files != (files := study.request()["files"]):
                rates = await asyncio.to_thread(study.rates)
            await self._look(study, file, rates.get(file, 0.0))

    async def draw(self, study: Study, file: str) -> None:
        """Make the small picture of a clip that a version without pictures has judged."""
        if "problem" not in study.request()["judged"].get(file, {"problem": ""}):
            rates = await asyncio.to_thread(study.rates)
            await self._look(study, file, rates.get(file, 0.0))

    async def _look(self, study: Study, file: str, rate: float) -> None:
        path = study.folder / INPUT / file
        facts = await self.readers.of(path).ask(judge, path, file, rate) or {"problem": CRASHED}
        if file in (request := study.request())["files"]:
            if "problem" in facts:
                facts["problem"] = study.without_paths(facts["problem"])
            if shown := facts.pop("figure", None):
                study.keep_figure(file, shown)
            study.change(judged={**request["judged"], file: facts})

    async def _delete_old(self) -> None:
        """Delete what nobody looked at for long enough while the server ran: no clock that is set counts."""
        while True:
            since, self._looked = self._looked, time.monotonic()
            for study in list(self.studies()):
                with suppress(RefusedError, OSError):
                    idle = study.idle_s() + self._looked - since
                    if idle > self.keep_s and not self.waits(study):
                        await self.delete(study)
                    else:
                        study.set_idle(idle)
            await asyncio.sleep(DAY_S / 24)


def _unjudged(study: Study) -> str:
    """The smallest file of a study that is not judged yet, or ""."""
    request, folder = study.request(), study.folder / INPUT
    files = (file for file in request["files"] if file not in request["judged"])
    motions = ((folder / file, file) for file in files if is_motion(folder / file))
    return min(((path.stat().st_size, file) for path, file in motions), default=(0, ""))[1]
