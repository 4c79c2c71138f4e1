# SPDX-License-Identifier: GPL-3.0-or-later
"""How commands end, and what several of them print."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import typer
from rich.console import Console

from w2w.core.findings.notes import left_out_sentences
from w2w.core.motion.source import UnusableMotion

NOTHING_TO_DO = 1
"""No result; a sentence on the screen says why."""

USAGE = 2
"""Wrong arguments, a missing folder, a labels file that cannot be understood."""

SKIPPED = 3
"""Clips were skipped and ``--strict`` was asked for."""

BUSY = 4
"""Another run works in the output folder."""


@contextmanager
def ending(code: int, console: Console, said: str = "") -> Iterator[None]:
    """End the command with an exit code where the block raises, after printing `said` and the error."""
    try:
        yield
    except (UnusableMotion, ValueError, OSError) as error:
        console.print(f"{said}{error}", style="red", markup=False)
        raise typer.Exit(code) from error


def show_left_out(left_out: Mapping[str, str], console: Console) -> None:
    """Print which activities were left out and why."""
    for sentence in left_out_sentences(left_out):
        console.print(f"Not ranked: {sentence}.", style="yellow", markup=False)


def sentence_of(error: Exception) -> str:
    """An error as a sentence, also where memory is lacking."""
    if not isinstance(error, MemoryError):
        return str(error)
    why = f" ({error})" if str(error) else ""
    return f"there is too little memory{why}: close other programs, or take fewer patches or workers"
