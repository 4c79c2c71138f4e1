# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress on the terminal: a bar or a spinner for whatever takes longer than a moment."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
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

NOTHING_TO_DO = 1
"""There is no result; a sentence on the screen says why."""

USAGE = 2
"""Wrong arguments, a missing folder, a labels file that cannot be understood."""

SKIPPED = 3
"""Clips were skipped and ``--strict`` was asked for."""

BUSY = 4
"""Another run works in the output folder."""

INTERRUPTED = 130
"""Stopped by Ctrl-C, as shells count it: 128 and the signal's number; so SIGTERM is 143, SIGHUP 129."""


def left_out_sentences(left_out: Mapping[str, str]) -> list[str]:
    """Which activities were left out and why, one sentence for each reason.

    Examples
    --------
    >>> left_out_sentences({"bow": "bow has no clip", "jump": "jump has no clip"})
    ['bow, jump: each has no clip']
    """
    names: dict[str, list[str]] = {}
    for name, reason in left_out.items():
        shared = reason.removeprefix(f"{name} ")
        names.setdefault(shared, []).append(name if shared != reason else "")
    return [_sentence(reason, group) for reason, group in names.items()]


def show_left_out(left_out: Mapping[str, str], console: Console) -> None:
    """Print which activities were left out and why."""
    for sentence in left_out_sentences(left_out):
        console.print(f"Not ranked: {sentence}.", style="yellow", markup=False)


def _sentence(reason: str, group: list[str]) -> str:
    if not group[0]:
        return reason
    return f"{group[0]} {reason}" if len(group) == 1 else f"{', '.join(group)}: each {reason}"


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
