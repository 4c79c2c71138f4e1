# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities that could not be ranked, a line for all that share a reason."""

from __future__ import annotations

from collections.abc import Mapping

from rich.console import Console


def show_left_out(left_out: Mapping[str, str], console: Console) -> None:
    """Print which activities were left out and why."""
    names: dict[str, list[str]] = {}
    for name, reason in left_out.items():
        names.setdefault(reason.removeprefix(name).strip(), []).append(name)
    for reason, group in names.items():
        console.print(f"Left out of the ranking: {', '.join(group)}, since each {reason}.", style="yellow")
