# SPDX-License-Identifier: GPL-3.0-or-later
"""Placements of one's own on the console: what each would give, and what it costs against the best."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table


def show_own_placements(placements: Sequence[dict[str, Any]], console: Console) -> None:
    """Print the placements, if there are any (`findings.own_placements.own_content`)."""
    if not placements:
        return
    table = Table(title="Your placements", title_justify="left")
    for column in ("placement", "region"):
        table.add_column(column)
    for column in ("expected F1", "rank", "loss against the best"):
        table.add_column(column, justify="right")
    for one in placements:
        loss = "as good as the best" if one["as_good"] else f"{one['loss']:.3f}"
        rank = f"{one['rank']} of {one['of']}"
        table.add_row(escape(one["name"]), one["region"], f"{one['expected_f1']:.3f}", rank, loss)
    console.print(table)
