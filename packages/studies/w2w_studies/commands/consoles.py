# SPDX-License-Identifier: GPL-3.0-or-later
"""What several of the studies' commands print on, and print."""

from rich.console import Console

from w2w.headless.console import Terminal

WIDTH = 140
"""Columns of a screen that is no terminal."""


def wide_console() -> Console:
    """A console on which the table is not squeezed when it is written to a file."""
    console = Terminal()
    return console if console.is_terminal else Terminal(width=WIDTH)


def show_caution(sentence: str, console: Console) -> None:
    """Print what a result has to be read with."""
    console.print(f"Caution: {sentence}.", style="yellow")
