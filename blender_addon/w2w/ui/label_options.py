# SPDX-License-Identifier: GPL-3.0-or-later
"""What an import dialog shows: which clips get which label, and what is left out and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import bpy

ROWS, NAMED = 12, 3
"""Activities, and files left out, that a dialog has room for; names of each that are shown."""

LONGEST = 64
"""Characters of a row, or it would widen the dialog beyond the window."""

WIDTH = 460
"""Pixels of a dialog at a scale of 1."""


def draw_preview(
    layout: bpy.types.UILayout,
    activities: Mapping[str, Sequence[str]],
    left_out: Sequence[tuple[str, str]],
    notes: Sequence[str] = (),
) -> None:
    """Draw the names of clips by the activity they would get, then what is left out and why.

    The empty activity is none: its clips are shown last, as what a ranking does not count.
    """
    count = sum(map(len, activities.values()))
    labels = [activity for activity in activities if activity]
    layout.label(
        text=f"{count} clip{'s' * (count != 1)}, {len(labels)} activit{'y' if len(labels) == 1 else 'ies'}"
    )
    box = layout.box().column(align=True)
    for activity in labels[:ROWS]:
        _row(box, activity, activities[activity], "NONE")
    if len(labels) > ROWS:
        box.label(text=f"and {len(labels) - ROWS} more activities")
    if activities.get(""):
        _row(box, "No activity, not ranked", activities[""], "ERROR")
    for note in notes:
        layout.label(text=_cut(note), icon="INFO", translate=False)
    if left_out:
        layout.label(text=f"{len(left_out)} left out")
        box = layout.box().column(align=True)
        for name, reason in left_out[:ROWS]:
            box.label(text=_cut(f"{name}: {reason}"), icon="X", translate=False)
        if len(left_out) > ROWS:
            box.label(text=f"and {len(left_out) - ROWS} more: the list says why")


def _row(layout: bpy.types.UILayout, activity: str, names: Sequence[str], icon: str) -> None:
    split = layout.split(factor=0.35)
    split.label(text=_cut(f"{activity}  ({len(names)})"), icon=icon, translate=False)
    about = split.row()
    about.active = False
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    about.label(text=_cut(", ".join(names[:NAMED]), LONGEST - len(more)) + more, translate=False)


def _cut(text: str, longest: int = LONGEST) -> str:
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
