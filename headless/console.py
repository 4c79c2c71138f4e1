# SPDX-License-Identifier: GPL-3.0-or-later
"""How commands end, and what several of them print."""

from __future__ import annotations

from collections.abc import Mapping

from rich.console import Console

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


def why_not(error: Exception) -> str:
    """What was raised as a sentence for people: of a file, which one and why, without the error's number.

    Examples
    --------
    >>> why_not(FileNotFoundError(2, "No such file or directory", "acc.npz"))
    'acc.npz cannot be opened: No such file or directory'
    """
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename} cannot be opened: {error.strerror}"
    return str(error)


def _sentence(reason: str, group: list[str]) -> str:
    if not group[0]:
        return reason
    return f"{group[0]} {reason}" if len(group) == 1 else f"{', '.join(group)}: each {reason}"
