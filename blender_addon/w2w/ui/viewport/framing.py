# SPDX-License-Identifier: GPL-3.0-or-later
"""Look at the body: 3D views from the side of a spot, the Outliner without a row for each patch."""

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Vector

from ...scene.base.body import body_of
from ..jobs.jobs import views
from ..study import lists, state

ROOM = 2.1
"""Distance of the view from a body, in its heights."""

BESIDE = 0.65
"""Distance of a body's middle from what it stands next to, in its heights: room for its arms."""

DRAWN_AFTER = 0.3
"""Seconds until Outliners have drawn a new collection."""

RISE = 0.12
"""Height from which the view looks down, as a share of its distance."""


def frame(bodies: Sequence[bpy.types.Object], vertex: int | None = None) -> None:
    """Show bodies whole in every 3D view, from the front or from the side of a vertex of the first."""
    low, high = extent(bodies)
    towards = Vector((0.0, -1.0, RISE))
    if vertex is not None:
        x, y = body_of(bodies[0]).vertex_normals[vertex][:2]
        if np.hypot(x, y) > 0.2:
            towards = Vector((x, y, RISE * float(np.hypot(x, y))))
    size = max(high[2] - low[2], 0.6 * float(np.hypot(*(high - low)[:2])))
    for area in views(bpy.context):
        view = area.spaces.active.region_3d
        if view.view_perspective == "CAMERA":
            view.view_perspective = "PERSP"
        view.view_location = Vector((low + high) / 2)
        view.view_rotation = towards.to_track_quat("Z", "Y")
        view.view_distance = ROOM * float(size)


def frame_answer(mesh: bpy.types.Object) -> None:
    """Show a body whole in every 3D view, from the side of its recommended spot if it has one."""
    patch, patches = lists.answer_of(mesh.w2w).get("patch"), state.patches_of(mesh)
    frame([mesh], None if patch is None or patches is None else int(patches.vertices[patch]))


def extent(items: Sequence[bpy.types.Object]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of objects in the world, shape (3,) each, metres."""
    bpy.context.view_layer.update()
    corners = np.concatenate([[item.matrix_world @ Vector(c) for c in item.bound_box] for item in items])
    return corners.min(axis=0), corners.max(axis=0)


def fold_outliners() -> None:
    """Fold every Outliner to what the top collections hold; a new collection is unfolded, however large."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "OUTLINER" and area.spaces.active.display_mode == "VIEW_LAYER":
                region = next(region for region in area.regions if region.type == "WINDOW")
                with bpy.context.temp_override(window=window, area=area, region=region):
                    bpy.ops.outliner.show_one_level(open=False)
                    bpy.ops.outliner.show_one_level()


def fold_soon() -> None:
    """Fold the Outliners once they have drawn what is new: before, it is not in them."""
    if not bpy.app.background:
        bpy.app.timers.register(fold_outliners, first_interval=DRAWN_AFTER)
