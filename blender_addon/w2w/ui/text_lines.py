# SPDX-License-Identifier: GPL-3.0-or-later
"""Break texts into lines that fit, by the width that Blender draws them at."""

from __future__ import annotations

import blf
import bpy

FONT = 0
PANEL_POINTS = 11
"""Size of the text in panels at a scale of 1."""


def wrapped(text: str, width: float) -> list[str]:
    """Lines of a panel text, none wider than `width` pixels unless a single word is."""
    blf.size(FONT, PANEL_POINTS * bpy.context.preferences.system.ui_scale)
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and blf.dimensions(FONT, longer)[0] <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
