# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a run has come, written down for whoever looks from another terminal."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from w2w.core.clip_files import WORK
from w2w.core.files import write_json

from .clip_task import ClipResult

# What an event is called, and its facts, is a promise: docs/engineer.md lists them.


@dataclass(frozen=True)
class EventLog:
    """Writes events as they happen.

    Parameters
    ----------
    stream : TextIO or None
        Where to; None for nowhere.
    """

    stream: TextIO | None = None

    def __call__(self, event: str, **facts: Any) -> None:
        """Write an event: its time (ISO 8601, UTC), its name and its facts."""
        if self.stream is None:
            return
        self.stream.write(event_line(event, **facts) + "\n")
        self.stream.flush()


def event_line(event: str, **facts: Any) -> str:
    """An event in one line of JSON."""
    time = datetime.now(UTC).isoformat(timespec="milliseconds")
    return json.dumps({"time": time, "event": event, **facts}, ensure_ascii=True, allow_nan=False)


SILENT = EventLog()
"""Writes nothing."""


EVERY_S = 0.5
"""Seconds between two writes, so that watching costs nothing."""


@dataclass
class RunState:
    """What `w2w status` shows.

    Parameters
    ----------
    step : str
        What the run is doing; "finished" or "failed" at its end.
    clips, done, skipped : int
        Clips in the library, done so far, and of those skipped.
    started, updated : float
        Seconds since the epoch, by a clock that may be set while the run goes on.
    spent : float
        Seconds between the two by one that only runs on.
    message : str
        The sentence a failed run ended with.
    """

    step: str = "starting"
    clips: int = 0
    done: int = 0
    skipped: int = 0
    started: float = 0.0
    updated: float = 0.0
    spent: float = 0.0
    message: str = ""


class Watch:
    """Keeps `RunState` on disk up to date.

    Parameters
    ----------
    out : Path
        The study's output folder.
    clips : int
        Clips in the library.
    log : EventLog
        Told of each step and clip.
    """

    def __init__(self, out: Path, clips: int, log: EventLog = SILENT) -> None:
        self.log = log
        self.path = state_file(out)
        now = time.time()
        self.state = RunState(clips=clips, started=now, updated=now)
        self._began = time.monotonic()
        self._written = self._began - EVERY_S

    def step(self, name: str, message: str = "") -> None:
        """Say what is done next."""
        self.state.step, self.state.message = name, message
        self.log("step", step=name)
        self._write()

    def clip_done(self, result: ClipResult) -> None:
        """Count a clip."""
        self.state.done += 1
        self.state.skipped += not result.used
        facts = result.details if result.used else {"reason": result.reason}
        count = {"done": self.state.done, "of": self.state.clips}
        self.log("clip", file=result.clip.file, used=result.used, **count, **facts)
        if time.monotonic() - self._written > EVERY_S:
            self._write()

    def _write(self) -> None:
        self._written = time.monotonic()
        self.state.updated, self.state.spent = time.time(), self._written - self._began
        write_json(self.path, asdict(self.state))


def state_file(out: Path) -> Path:
    """Where the state of the run in a folder stands."""
    return out / WORK / "state.json"


def read_state(out: Path) -> RunState:
    """The state of the run in a folder.

    Raises
    ------
    OSError, ValueError
        If there is none or it cannot be understood.
    """
    return RunState(**json.loads(state_file(out).read_text(encoding="utf-8")))
