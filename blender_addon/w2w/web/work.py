# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of the web app: runs as processes of the command line, and a worker that opens files."""

import asyncio
import json
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TypeVar

from ..core.library.library import is_motion
from ..headless.runs.workers import Workers, local_executor
from ..headless.stopping import deaf_children
from .study import EVENTS, ID, INPUT, REQUEST, Study
from .uploads import judge

Result = TypeVar("Result")

COMMAND = (
    "import sys; from w2w.headless.runs.guard import end_with; end_with(int(sys.argv.pop(1))); "
    "from w2w.headless.start import main; main()"
)
"""The command line as a process that ends with the server."""

PATIENCE_S = 10.0
"""Seconds that a run gets to stop by itself."""

REMEMBERED_S = 900
"""Seconds without a question after which a study that is chosen from is forgotten."""

DAY_S = 86400


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


class Work:
    """What is to be done in a data folder: files to judge, runs to do, old studies to delete."""

    def __init__(self, data: Path, at_once: int, scheduler: str, keep_days: float) -> None:
        self.data, self.scheduler, self.keep_s = data, scheduler, keep_days * DAY_S
        self.reader, self.chooser, self.running = Reader(), Reader(REMEMBERED_S), set[str]()
        self._workers = max(1, (os.cpu_count() or 1) // at_once)
        self._places = asyncio.Semaphore(at_once)
        self._runs: dict[str, asyncio.Task[None]] = {}
        self._judging: dict[str, asyncio.Task[None]] = {}
        self._keeper: asyncio.Task[None] | None = None
        self._preparing: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Go on where an earlier server was."""
        waiting = [study for study in self.studies() if study.waits]
        for study in sorted(waiting, key=lambda study: study.request()["asked"]):
            self.run(study)
        self._keeper = asyncio.create_task(self._delete_old())

    async def stop(self) -> None:
        """End all work; runs go on with the next server."""
        others = [task for task in (self._keeper, self._preparing) if task]
        tasks = [*self._runs.values(), *self._judging.values(), *others]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self.reader.close()
        self.chooser.close()

    def studies(self) -> Iterator[Study]:
        """All studies of all owners."""
        for path in self.data.glob(f"*/*/{REQUEST}"):
            if ID.fullmatch(path.parent.name):
                yield Study(path.parent)

    def run(self, study: Study) -> None:
        """Do a study's run as soon as there is a place; it judges all files itself."""
        if task := self._judging.get(study.id):
            task.cancel()
        if study.id not in self._runs:
            self._runs[study.id] = task = asyncio.create_task(self._run(study))
            task.add_done_callback(lambda _: self._runs.pop(study.id, None))

    async def cancel(self, study: Study) -> None:
        """Stop a study's run, or take it from the queue; what is finished is kept."""
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
        async with self._places:
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
        if study.end() is None:  # it could not say what happened
            problem = "The run was killed: there may be too little memory. Run again to go on."
            ended = {"event": "finished", "exit_code": 1, "problem": problem}
            with (study.folder / EVENTS).open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(ended) + "\n")

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
                rates = study.rates()
            found = await self.reader.ask(judge, study.folder / INPUT / file, file, rates.get(file, 0.0))
            if file in (request := study.request())["files"]:
                dead = {"problem": "it is damaged, or far too long: the program that reads it crashed"}
                study.change(judged={**request["judged"], file: dead if found is None else found})

    async def _delete_old(self) -> None:
        while True:
            for study in list(self.studies()):
                used = (study.folder / REQUEST).stat().st_mtime
                if time.time() - used > self.keep_s and not study.waits:
                    await self.delete(study)
            await asyncio.sleep(DAY_S / 24)


def _unjudged(study: Study) -> str:
    """A file of a study that is not judged yet, or ""."""
    request = study.request()
    names = (file for file in request["files"] if file not in request["judged"])
    return next((file for file in names if is_motion(study.folder / INPUT / file)), "")
