# SPDX-License-Identifier: GPL-3.0-or-later
"""Look at the body: 3D views from the side of a spot, the Outliner without a row for each patch."""

from collections.abc import Iterator, Sequence

import bpy
import numpy as np
from mathutils import Quaternion, Vector

from ...core.body.body import FROM_ABOVE, JOINT_NAMES, first_turn
from ...drawing.places import FreeArea
from ...scene import heatmap
from ...scene.base.body import armature_of, body_of, matrix, moved, read_values, select
from ..jobs.jobs import views
from ..study import lists, operators, state

MARGIN = 1.06
"""How much larger than the bodies the part of a view is that they are shown in."""

FITTING = 8
"""Times that a view is fitted again: what is near looks larger."""

SOLID = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
"""Types of objects that cover others."""

LEGEND_ROOM = 150
"""Pixels that a view leaves the legend at its right, at a scale of 1."""

FOOT_ROOM, AXES_ROOM, BUTTON_ROOM = 46, 80, 48
"""Pixels at a scale of 1 that a narrow view leaves the legend at its foot, and Blender's axes and buttons."""

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

_hips: dict[str, Vector] = {}
"""Where the hips of the body were that 3D views go with, but for where its armature stands."""

hidden: set[str] = set()
"""Names of what was hidden to show a body alone."""


def free_area(area: bpy.types.Area, region: bpy.types.Region) -> FreeArea:
    """The part of a 3D view's region that no other region covers, pixels."""
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
    return FreeArea(left, right, bottom, top)


def frame(bodies: Sequence[bpy.types.Object], vertex: int | None = None) -> None:
    """Show bodies whole in every 3D view, from the front or as a vertex of the first is first looked at."""
    turn = 0.0 if vertex is None else first_turn(body_of(bodies[0]), vertex)
    towards = Vector((np.sin(turn), -np.cos(turn), FROM_ABOVE))
    for item in bodies:
        bring_into_view(item)
    points = np.concatenate([surface(item) for item in bodies])
    for area in views(bpy.context):
        for item in bodies if area.spaces.active.local_view else ():
            item.local_view_set(area.spaces.active, True)
        _look_at(area, points, towards.normalized())


def _look_at(area: bpy.types.Area, points: np.ndarray, towards: Vector) -> None:
    """Turn a 3D view so that points (N, 3) fill what no panel covers of it, but for the legend's room."""
    space, region = area.spaces.active, next(part for part in area.regions if part.type == "WINDOW")
    view, turn = space.region_3d, towards.to_track_quat("Z", "Y")
    if view.view_perspective == "CAMERA":
        view.view_perspective = "PERSP"
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    seen = (points - middle) @ np.array(turn.to_matrix())  # to the right, up, towards the viewer
    rooms = _rooms(free_area(area, region), bpy.context.preferences.system.ui_scale)
    low, high = max(rooms, key=lambda room: (np.subtract(*room[::-1]) / np.ptp(seen[:, :2], axis=0)).min())
    room, aside = np.maximum(high - low, 1), (low + high - (region.width, region.height)) / 2
    pixels, depth = max(region.width, region.height) * space.lens / SENSOR, 0.0 * seen[:, 2:]
    if view.view_perspective == "PERSP":  # what is beside the middle is seen more from there
        turn = Quaternion((0, 0, 1), np.arctan(aside[0] / pixels)) @ turn
        seen = (points - middle) @ np.array(turn.to_matrix())
        depth = seen[:, 2:]
    nearest = float(depth.max())
    distance, centre = nearest + float(np.ptp(seen)), np.zeros(2)
    for _ in range(FITTING):
        spots = pixels * (seen[:, :2] - centre) / (distance - depth)
        low, high = spots.min(axis=0), spots.max(axis=0)
        centre += ((low + high) / 2 - aside) * distance / pixels
        distance = nearest + (distance - nearest) * MARGIN * float(((high - low) / room).max())
    view.view_location = Vector(middle) + turn @ Vector((*centre, 0.0))
    view.view_rotation, view.view_distance = turn, distance


def _rooms(free: FreeArea, scale: float) -> list[np.ndarray]:
    """Lowest and highest corner of what a body may fill: beside an upright legend, or over a flat one."""
    left, right, bottom, top = free
    beside = max(right - LEGEND_ROOM * scale, (left + right) / 2)
    over = (right - BUTTON_ROOM * scale, top - AXES_ROOM * scale)
    return [np.array([(left, bottom), (beside, top)]), np.array([(left, bottom + FOOT_ROOM * scale), over])]


def bring_into_view(item: bpy.types.Object) -> None:
    """Show an object that is hidden, or whose collections are."""
    item.hide_viewport = False
    for home in item.users_collection:
        home.hide_viewport = False
    layers = [bpy.context.view_layer.layer_collection]
    for layer in layers:
        layers += layer.children
        if layer.collection in item.users_collection:
            layer.exclude = layer.hide_viewport = False
    bpy.context.view_layer.update()
    item.hide_set(False)


def hide_others(bodies: Sequence[bpy.types.Object]) -> None:
    """Hide all solid things but bodies and what these wear."""
    own = set().union(*map(dressed, bodies))
    for item in bpy.context.view_layer.objects:
        is_ours = item in own or heatmap.BESIDE in item or (item.type == "MESH" and item.w2w.is_body)
        if item.type in SOLID and not is_ours and item.visible_get():
            item.hide_set(True)
            hidden.add(item.name)


def hidden_ones() -> list[bpy.types.Object]:
    """What `hide_others` hid and is hidden still."""
    found = (bpy.context.view_layer.objects.get(name) for name in sorted(hidden))
    return [item for item in found if item is not None and item.hide_get()]


class W2W_OT_show_others(operators.WorkOperator, bpy.types.Operator):
    """Show again what was hidden to show the body alone"""

    def work(self, context: bpy.types.Context, _body: bpy.types.Object | None) -> None:
        for item in hidden_ones():
            item.hide_set(False)
        hidden.clear()


def dressed(body: bpy.types.Object) -> set[bpy.types.Object]:
    """A body and what it wears, which hides nothing of it."""
    return {body, *(worn.item for worn in body.w2w.covers)}


def stand_clear(armature: bpy.types.Object, mesh: bpy.types.Object) -> None:
    """Move a new body to the right of what stands where it does, such as the default cube."""
    low, high = extent([mesh])
    tall = high[2] - low[2]
    others = [item for item in bpy.context.view_layer.objects if item.type in SOLID and item.visible_get()]
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


def frame_answer(mesh: bpy.types.Object) -> None:
    """Show a body alone, from the side of its recommended spot if it has one."""
    patch, patches = lists.answer_of(mesh.w2w).get("patch"), state.patches_of(mesh)
    frame([mesh], None if patch is None or patches is None else int(patches.vertices[patch]))
    select(())  # an outline would hide colours
    hide_others([mesh])


def go_with(body: bpy.types.Object, move: bool) -> None:
    """Note where a body's hips are; if asked, `move` all 3D views along the ground as they went since."""
    armature = armature_of(body)
    hips = armature.matrix_world.to_3x3() @ armature.pose.bones[JOINT_NAMES[0]].matrix.translation
    for area in views(bpy.context) if move and body.name in _hips else ():
        view = area.spaces.active.region_3d
        view.view_location.xy += hips.xy - _hips[body.name].xy
    _hips.clear()
    _hips[body.name] = hips


def surface(item: bpy.types.Object) -> np.ndarray:
    """Points (N, 3) in the world of a body as it is posed, metres."""
    shown = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    vertices = shown.data.vertices
    points = read_values(vertices, "co", 3 * len(vertices), np.float32).reshape(-1, 3)
    return moved(points, matrix(shown.matrix_world))


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
