# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens in a run, for machines: one JSON object a line."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TextIO

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
