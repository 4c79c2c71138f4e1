# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's progress: on the console, as events for programs, and in a file for `w2w status`."""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from ...core.files import write_json
from ...core.given import inside
from ...core.library.library import Library
from ...core.study.clip_files import WORK
from ...core.study.results import ClipResult
from ...core.wording import capital

# What an event is called, and its facts, is a promise: docs/engineer.md lists them.


@dataclass(frozen=True)
class EventLog:
    """Writes events to a stream as they happen; nowhere without one."""

    stream: TextIO | None = None

    def __call__(self, event: str, **facts: Any) -> None:
        if self.stream is not None:
            self.stream.write(event_line(event, **facts) + "\n")
            self.stream.flush()


def event_line(event: str, **facts: Any) -> str:
    """An event in one line of JSON: its time (ISO 8601, UTC), its name and its facts."""
    time = datetime.now(UTC).isoformat(timespec="milliseconds")
    return json.dumps({"time": time, "event": event, **facts}, ensure_ascii=True, allow_nan=False)


EVERY_S = 0.5
"""Seconds between two writes, so that watching costs nothing."""


@dataclass
class RunState:
    """The state of a run, for `w2w status`."""

    step: str = "starting"
    """The step it is at; "finished" or "failed" at its end."""
    clips: int = 0
    done: int = 0
    skipped: int = 0
    """How many of the finished clips were skipped."""
    started: float = 0.0
    updated: float = 0.0
    """Seconds since the epoch, by a clock that may be set meanwhile."""
    spent: float = 0.0
    """Seconds between the two by a clock that cannot."""
    message: str = ""
    """Why it failed."""


class RunMonitor:
    """Says how a run goes: on the console, as events, and in its folder once that is known."""

    def __init__(self, console: Console, log: EventLog = EventLog()) -> None:
        self.console, self.log = console, log
        self.state = RunState()
        self._path: Path | None = None
        self._began = self._written = 0.0

    def begin(self, library: Library, body: str, out: Path, kept: bool = True) -> None:
        """Say that a run starts, and if wanted keep its state in its folder from now on."""
        clips = library.clips
        self.log("started", out=str(out), body=body, clips=len(clips), activities=library.activities)
        for file, reason in library.skipped:
            self.log("clip", file=file, used=False, reason=reason)
        now = time.time()
        self.state = RunState(clips=len(clips), started=now, updated=now)
        self._path, self._began = state_file(out) if kept else None, time.monotonic()
        self._written = self._began - EVERY_S

    def announce(self, step: str, message: str = "") -> None:
        """Say what is done next, or how the run ended; a step that goes on is not said again."""
        if step == self.state.step:
            return
        self.state.step, self.state.message = step, message
        self.log("step", step=step)
        self._write()

    def step(self, name: str, title: str = "") -> AbstractContextManager[object]:
        """Announce a step of unknown length and show that it runs while the block does."""
        columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        return self._shown(name, title, columns)

    def bar(self, name: str, total: int, title: str = "") -> AbstractContextManager[Callable[[int], None]]:
        """Announce a step and show a bar while the block runs, which says how many steps it advances."""
        columns = (
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
            TextColumn("left"), TimeRemainingColumn(),
        )  # fmt: skip
        return self._shown(name, title, columns, total)

    def clip_done(self, result: ClipResult) -> None:
        self.state.done += 1
        self.state.skipped += not result.used
        if self.log.stream is not None:
            facts = result.details if result.used else {"reason": result.reason}
            count = {"done": self.state.done, "of": self.state.clips}
            self.log("clip", file=result.clip.file, used=result.used, **count, **facts)
        if time.monotonic() - self._written > EVERY_S:
            self._write()

    @contextmanager
    def _shown(
        self, name: str, title: str, columns: Sequence[ProgressColumn], total: int | None = None
    ) -> Iterator[Callable[[int], None]]:
        """Show a step by its title, or its name, and at its end how long it took."""
        self.announce(name)
        title, start = title or capital(name), time.perf_counter()
        with Progress(*columns, console=self.console, transient=True) as display:
            task = display.add_task(title, total=total)
            yield lambda steps: display.advance(task, steps)
        self.console.print(f"{title}: {time.perf_counter() - start:.1f} s", style="dim")

    def _write(self) -> None:
        if self._path is None:
            return
        self._written = time.monotonic()
        self.state.updated, self.state.spent = time.time(), self._written - self._began
        write_json(self._path, asdict(self.state))


def state_file(out: Path) -> Path:
    """The file with the state of the run in a folder."""
    return inside(out, f"{WORK}/state.json")


def read_state(out: Path) -> RunState:
    """The state of the run in a folder; an OSError or ValueError if there is none."""
    return RunState(**json.loads(state_file(out).read_text(encoding="utf-8")))
