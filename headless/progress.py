# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress on the terminal: a bar or a spinner for whatever takes longer than a moment."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as RichProgress


class Progress:
    """Shows what is going on, and keeps how long each step took.

    Parameters
    ----------
    console : Console
        Where to show it; one that is no terminal gets a line a step instead.

    Attributes
    ----------
    seconds : dict of str to float
        Wall-clock time of each step that has ended.
    """

    def __init__(self, console: Console) -> None:
        self.console = console
        self.seconds: dict[str, float] = {}

    @contextmanager
    def bar(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        """Show a bar while the block runs; call what it gives with each advance."""
        with self._timed(title), self._shown(
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
            TextColumn("left"), TimeRemainingColumn(),
        ) as display:  # fmt: skip
            task = display.add_task(title, total=total)
            yield lambda steps: display.advance(task, steps)

    @contextmanager
    def spinner(self, title: str) -> Iterator[None]:
        """Show that a step of unknown length is running."""
        columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        with self._timed(title), self._shown(*columns) as display:
            display.add_task(title, total=None)
            yield

    def _shown(self, *columns: object) -> RichProgress:
        return RichProgress(*columns, console=self.console, transient=True)

    @contextmanager
    def _timed(self, title: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[title] = time.perf_counter() - start
        self.console.print(f"{title}: {self.seconds[title]:.1f} s", style="dim", highlight=False)
