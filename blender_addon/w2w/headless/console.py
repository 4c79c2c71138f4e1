# SPDX-License-Identifier: GPL-3.0-or-later
"""Exit codes of commands, and output that several of them share."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.text import Text

from ..core.motion.source import UnusableMotion
from ..core.ranking.folds import left_out_sentences
from ..core.study.results import UnfinishedError
from ..core.wording import harmless

NOTHING_TO_DO = 1
"""No result; a sentence on the screen says why."""

USAGE = 2
"""Wrong arguments, a missing folder, a labels file that cannot be understood."""

SKIPPED = 3
"""Clips were skipped and ``--strict`` was asked for."""

BUSY = 4
"""Another run works in the output folder, or has left it unfinished."""


class Terminal(Console):
    """A console to which texts are but texts: no markup, no emoji, nothing that the terminal would obey."""

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, highlight=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(harmless(text), **options)


def console_beside(as_json: bool) -> Terminal:
    """A console for people; where a program reads the output, it says on stderr what is wrong, no more."""
    return Terminal(stderr=as_json, quiet=as_json)


def print_json(content: object) -> None:
    """Print what a command found for programs, and nothing else."""
    print(json.dumps(content, ensure_ascii=False, indent=2))


@contextmanager
def ending(code: int, console: Console, prefix: str = "") -> Iterator[None]:
    """End the command with an exit code if the block raises, after printing `prefix` and the error.

    The code is BUSY if a results folder is unfinished.
    """
    try:
        yield
    except (UnusableMotion, ValueError, OSError) as error:
        console.quiet = False
        console.print(f"{prefix}{sentence_of(error)}", style="red")
        raise typer.Exit(BUSY if isinstance(error, UnfinishedError) else code) from error


def show_left_out(left_out: Mapping[str, str], console: Console) -> None:
    """Print which activities were left out and why."""
    for sentence in left_out_sentences(left_out):
        console.print(f"Not ranked: {sentence}.", style="yellow")


def sentence_of(error: Exception) -> str:
    """An error as a sentence: for a file which one and why, without the error's number.

    Examples
    --------
    >>> sentence_of(FileNotFoundError(2, "No such file or directory", "acc.npz"))
    'acc.npz cannot be opened: No such file or directory'
    """
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename} cannot be opened: {error.strerror}"
    if not isinstance(error, MemoryError):
        return str(error)
    why = f" ({error})" if str(error) else ""
    return f"there is too little memory{why}: close other programs, or take fewer patches or workers"
