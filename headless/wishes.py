# SPDX-License-Identifier: GPL-3.0-or-later
"""Options by which a designer says where sensors may go: the same for `w2w run` and `w2w place`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from blender_addon.w2w.core.constraints import Constraints, read_costs

PANEL = "Design constraints"

Only = Annotated[
    str,
    typer.Option(
        help="Use only these regions, comma-separated: 'left', 'left,middle', 'arm,torso', 'left wrist'.",
        rich_help_panel=PANEL,
    ),
]
Forbid = Annotated[
    str, typer.Option(help="Never use these regions: 'head,hand,foot'.", rich_help_panel=PANEL)
]
Must = Annotated[
    str,
    typer.Option(
        help="Use at least one place in each of these regions: 'left wrist'.", rich_help_panel=PANEL
    ),
]
MaxPlaces = Annotated[
    int | None, typer.Option("--max", min=1, help="Maximum number of sensors.", rich_help_panel=PANEL)
]
Costs = Annotated[
    Path | None,
    typer.Option(
        "--cost",
        help="csv with columns region, cost: price or discomfort of a sensor there (1 elsewhere).",
        rich_help_panel=PANEL,
    ),
]


def parse_wishes(only: str, forbid: str, must: str, costs: Path | None) -> Constraints:
    """The options as `Constraints`.

    Raises
    ------
    ValueError, OSError
        If a cost is wrong or its table cannot be read.
    """
    return Constraints(_words(only), _words(forbid), _words(must), read_costs(costs) if costs else ())


def _words(text: str) -> tuple[str, ...]:
    return tuple(part.strip() for part in text.split(",") if part.strip())
