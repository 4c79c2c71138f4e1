# SPDX-License-Identifier: GPL-3.0-or-later
"""The 3D views look at the body, at most from the side of a spot."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Vector

from ...scene.base.body import body_of

ROOM = 2.1
"""Distance of the view from a body, in its heights."""

RISE = 0.12
"""How far the view looks down, as a share of its distance."""


def frame(bodies: Sequence[bpy.types.Object], vertex: int | None = None) -> None:
    """Show bodies whole in every 3D view, from the front or from the side of a vertex of the first."""
    corners = np.concatenate([[item.matrix_world @ Vector(c) for c in item.bound_box] for item in bodies])
    low, high = corners.min(axis=0), corners.max(axis=0)
    towards = Vector((0.0, -1.0, RISE))
    if vertex is not None:
        x, y = body_of(bodies[0]).vertex_normals[vertex][:2]
        if np.hypot(x, y) > 0.2:
            towards = Vector((x, y, RISE * float(np.hypot(x, y))))
    size = max(high[2] - low[2], 0.6 * float(np.hypot(*(high - low)[:2])))
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                view = area.spaces.active.region_3d
                if view.view_perspective == "CAMERA":
                    view.view_perspective = "PERSP"
                view.view_location = Vector((low + high) / 2)
                view.view_rotation = towards.to_track_quat("Z", "Y")
                view.view_distance = ROOM * float(size)
