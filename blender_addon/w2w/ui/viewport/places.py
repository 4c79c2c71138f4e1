# SPDX-License-Identifier: GPL-3.0-or-later
"""What cards and the legend keep clear in a 3D view: bodies, and what Blender itself shows."""

from collections.abc import Iterable

import bpy
import numpy as np

from ...drawing.places import Box, FreeArea
from .framing import BUTTON_ROOM, surface

SPARSE = 6
"""One in so many vertices of a body is kept clear."""

INFO_TEXT, GIZMO, BUTTONS = (220, 72), (100, 100), (BUTTON_ROOM, 218)
"""Width and height of Blender's own lines at the top left, axes and buttons at the right, at a scale of 1."""


def blenders_own(context: bpy.types.Context, free: FreeArea, scale: float) -> list[Box]:
    """What Blender itself writes and draws in the corners of a view."""
    wide, tall = INFO_TEXT
    boxes = [
        Box(free.right - across * scale, free.top - down * scale, free.right, free.top)
        for across, down in (GIZMO, BUTTONS)
    ]
    if context.space_data.overlay.show_text:
        boxes.append(Box(free.left, free.top - tall * scale, free.left + wide * scale, free.top))
    return boxes


def seen(context: bpy.types.Context, bodies: Iterable[bpy.types.Object]) -> np.ndarray:
    """Points (K, 2) of bodies' surfaces in the region, pixels; those behind the viewer are left out."""
    points = np.concatenate([surface(body)[::SPARSE] for body in bodies])
    whole = (
        np.column_stack([points, np.ones(len(points))]) @ np.array(context.region_data.perspective_matrix).T
    )
    whole = whole[whole[:, 3] > 0]
    size = np.array([context.region.width, context.region.height])
    return (whole[:, :2] / whole[:, 3:] + 1) / 2 * size
