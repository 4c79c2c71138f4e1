# SPDX-License-Identifier: GPL-3.0-or-later
"""Look at the body: 3D views from the side of a spot, the Outliner without a row for each patch."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Vector

from ...core.wording import listed
from ...scene.base.body import body_of
from ..jobs.jobs import views
from ..study import lists, state

MARGIN = 1.1
"""How much larger than the bodies the part of a view is that they are shown in."""

LEGEND_ROOM = 150
"""Pixels that a view leaves the legend at its right, at a scale of 1."""

INFO_TEXT = 72
"""Height of Blender's own lines at the top left, pixels."""

SENSOR = 72
"""Width of what a view sees at the distance of its lens, millimetres."""

ANKLE = 0.1
"""Height up to which a new body stands on things, in its heights: they are ground."""

SURROUNDINGS = 6.0
"""Width from which on things surround a body, in its heights; it is not moved clear of them."""

BESIDE = 0.65
"""Distance of a body's middle from what it stands next to, in its heights: room for its arms."""

DRAWN_AFTER = 0.3
"""Seconds until Outliners have drawn a new collection."""

LEVELS = 8
"""At least as many as an Outliner has: to fold the deepest alone would unfold it again."""

SPARSE = 40
"""One in so many vertices is looked at to find what covers a body."""

RISE = 0.12
"""Height from which the view looks down, as a share of its distance."""


class FreeArea(NamedTuple):
    """The part of a region that no panel covers."""

    left: float
    right: float
    bottom: float
    top: float


def free_area(area: bpy.types.Area, region: bpy.types.Region) -> FreeArea:
    """The part of a 3D view's region that no other region and no text of Blender's covers, pixels."""
    system = bpy.context.preferences.system
    left, right, bottom, top = 0.0, float(region.width), 0.0, float(region.height)
    if not system.use_region_overlap:
        return FreeArea(left, right, bottom, top)
    for other in area.regions:
        if other.width <= 1 or other.height <= 1 or other.alignment == "NONE":
            continue
        if other.type == "UI":
            right = min(right, other.x - region.x)
        elif other.type == "HUD":
            bottom = max(bottom, other.y + other.height - region.y)
        elif other.type == "TOOLS":
            left = max(left, other.x + other.width - region.x)
        elif other.type in ("HEADER", "TOOL_HEADER") and other.y > region.y + region.height / 2:
            top = min(top, other.y - region.y)
    if area.spaces.active.overlay.show_text:
        top -= INFO_TEXT * system.ui_scale
    return FreeArea(left, right, bottom, top)


def frame(bodies: Sequence[bpy.types.Object], vertex: int | None = None) -> str:
    """Show bodies whole in every 3D view, from the front or from the side of a vertex of the first.

    What stands before them is hidden; returns a sentence that says so, or "".
    """
    towards = Vector((0.0, -1.0, RISE))
    if vertex is not None:
        x, y = body_of(bodies[0]).vertex_normals[vertex][:2]
        if np.hypot(x, y) > 0.2:
            towards = Vector((x, y, RISE * float(np.hypot(x, y))))
    hidden = set()
    for area in views(bpy.context):
        for item in bodies if area.spaces.active.local_view else ():
            item.local_view_set(area.spaces.active, True)
        hidden |= _clear_sight(bodies, _look_at(area, bodies, towards.normalized()))
    names = listed(sorted(item.name for item in hidden))
    return f"Hidden to show the whole body: {names}. Alt H brings it back." if hidden else ""


def _look_at(area: bpy.types.Area, bodies: Sequence[bpy.types.Object], towards: Vector) -> Vector:
    """Turn a 3D view so that bodies fill what no panel covers of it; returns the viewer's point."""
    space, region = area.spaces.active, next(part for part in area.regions if part.type == "WINDOW")
    view, turn = space.region_3d, towards.to_track_quat("Z", "Y")
    low, high = map(Vector, extent(bodies))
    wide, tall, deep = (
        sum(abs(a * b) for a, b in zip(turn @ Vector(axis), high - low, strict=True))
        for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    )
    free, scale = free_area(area, region), bpy.context.preferences.system.ui_scale
    right = max(free.right - LEGEND_ROOM * scale, (free.left + free.right) / 2)
    a_pixel = MARGIN * max(wide / max(right - free.left, 1), tall / max(free.top - free.bottom, 1))
    distance = a_pixel * max(region.width, region.height) * space.lens / SENSOR + deep / 2
    across = (free.left + right - region.width) / 2
    up = (free.bottom + free.top - region.height) / 2
    if view.view_perspective == "CAMERA":
        view.view_perspective = "PERSP"
    view.view_location = (low + high) / 2 - turn @ Vector((across * a_pixel, up * a_pixel, 0.0))
    view.view_rotation, view.view_distance = turn, distance
    return view.view_location + distance * towards


def _clear_sight(bodies: Sequence[bpy.types.Object], viewer: Vector) -> set[bpy.types.Object]:
    """Hide what stands between a viewer and bodies, but for what they wear; returns what is hidden now."""
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    shown = [item.evaluated_get(depsgraph) for item in bodies]
    points = [item.matrix_world @ spot.co for item in shown for spot in [*item.data.vertices][::SPARSE]]
    own = set().union(*map(with_garments, bodies))
    found: set[bpy.types.Object] = set()
    while True:
        bpy.context.view_layer.update()
        rays = [spot - viewer for spot in points]
        hits = [scene.ray_cast(depsgraph, viewer, ray, distance=ray.length) for ray in rays]
        new = {hit[4] for hit in hits if hit[0]} - own - found
        if not new:
            return found
        for item in new:
            item.hide_set(True)
        found |= new


def with_garments(body: bpy.types.Object) -> set[bpy.types.Object]:
    """A body and what it wears, which hides nothing of it."""
    return {body, *(garment.item for garment in body.w2w.garments)}


def stand_clear(armature: bpy.types.Object, mesh: bpy.types.Object) -> None:
    """Move a new body to the right of what stands where it does, such as the default cube."""
    low, high = extent([mesh])
    tall = high[2] - low[2]
    solid = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
    others = [item for item in bpy.context.view_layer.objects if item.type in solid and item.visible_get()]
    boxes = [extent([item]) for item in others if item != mesh]
    while True:
        low, high = extent([mesh])
        low[2] += ANKLE * tall
        met = [
            end[0] for begin, end in boxes
            if (begin < high).all() and (end > low).all() and max(end[:2] - begin[:2]) < SURROUNDINGS * tall
        ]  # fmt: skip
        if not met:
            return
        armature.location.x += max(met) - low[0] + (BESIDE - 0.5) * tall


def frame_answer(mesh: bpy.types.Object) -> str:
    """Show a body as `frame` does, from the side of its recommended spot if it has one."""
    patch, patches = lists.answer_of(mesh.w2w).get("patch"), state.patches_of(mesh)
    return frame([mesh], None if patch is None or patches is None else int(patches.vertices[patch]))


def extent(items: Sequence[bpy.types.Object]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of objects in the world, shape (3,) each, metres."""
    bpy.context.view_layer.update()
    corners = np.concatenate([[item.matrix_world @ Vector(c) for c in item.bound_box] for item in items])
    return corners.min(axis=0), corners.max(axis=0)


def _outliners() -> Iterator[tuple[bpy.types.Window, bpy.types.Area]]:
    """Every Outliner, and the window that it is in."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "OUTLINER":
                yield window, area


def fold_outliners() -> None:
    """Fold every Outliner to what the top collections hold, or to these where patches are one of them."""
    for window, area in _outliners():
        top, bodies = set(window.scene.collection.children), state.bodies(window.scene)
        shown = 1 if any(body.w2w.patch_collection in top for body in bodies) else 2
        if area.spaces.active.display_mode == "VIEW_LAYER":
            region = next(region for region in area.regions if region.type == "WINDOW")
            with bpy.context.temp_override(window=window, area=area, region=region):
                for _ in range(LEVELS):
                    bpy.ops.outliner.show_one_level(open=False)
                for _ in range(shown):
                    bpy.ops.outliner.show_one_level()


def fold_soon() -> None:
    """Fold the Outliners once they have drawn what is new: before, it is not in them."""
    if not bpy.app.background:
        for _, area in _outliners():
            area.tag_redraw()
        bpy.app.timers.register(fold_outliners, first_interval=DRAWN_AFTER)
