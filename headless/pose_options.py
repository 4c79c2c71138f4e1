# SPDX-License-Identifier: GPL-3.0-or-later
"""Options for joint positions from video: what their files do not say of themselves."""

from __future__ import annotations

from typing import Annotated

import typer

from w2w.core.keypoints.facts import UNITS, UPS, PoseFacts
from w2w.core.keypoints.joint_sets import JOINT_SETS

PANEL = "Joint positions from video (csv, npy, npz, json)"

PoseRate = Annotated[
    float | None,
    typer.Option(
        min=1,
        max=2000,
        help="Frames per second, where the files do not say them (of amc files 120 otherwise).",
        rich_help_panel=PANEL,
    ),
]
PoseUnit = Annotated[
    str, typer.Option(help=f"Unit of the positions: {', '.join(UNITS)}.", rich_help_panel=PANEL)
]
PoseUp = Annotated[
    str,
    typer.Option(
        help=f"Axis that points up: {', '.join(UPS)}.  [default: where the trunk points]",
        rich_help_panel=PANEL,
    ),
]
PoseJoints = Annotated[str, typer.Option(help=f"Joint set: {', '.join(JOINT_SETS)}.", rich_help_panel=PANEL)]


def pose_facts(rate: float | None, unit: str, up: str, joints: str) -> PoseFacts:
    """The options as `PoseFacts`.

    Raises
    ------
    ValueError
        If a unit, axis or joint set is unknown.
    """
    return PoseFacts(rate, unit or None, up or None, joints or None)
