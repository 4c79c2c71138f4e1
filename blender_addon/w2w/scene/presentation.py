# SPDX-License-Identifier: GPL-3.0-or-later
"""A body as pictures show it: in a neutral pose or as it is posed, with its colours."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from mathutils import Matrix

from ..core.body.body import JOINT_NAMES
from .base.actions import show_action
from .base.body import armature_of, matrix, moved, painted_colours, read_values, triangles_of
from .base.module import bpy
from .base.playback import each_frame

ARMS_DOWN = {"left_shoulder": np.radians(62), "right_shoulder": np.radians(-62)}
"""Turns about the axis from back to front of the bones that hang in a neutral pose, radians."""

CLOTH = (0.86, 0.87, 0.89)
"""sRGB colour of what is not painted."""


def facing(mesh: bpy.types.Object) -> float:
    """Turn about z, radians, of the way that a body's hips face now; 0 is along -y."""
    armature = armature_of(mesh)
    pelvis = armature.pose.bones[JOINT_NAMES[0]]
    turned = matrix(armature.matrix_world @ pelvis.matrix @ pelvis.bone.matrix_local.inverted())
    x, y, _ = -turned[:3, 1]
    return float(np.arctan2(x, -y))


@contextmanager
def posed(mesh: bpy.types.Object, action: bpy.types.Action | None = None) -> Iterator[None]:
    """Inside, a body plays an action, or stands upright with its arms down; at the end all is as it was."""
    armature, scene = armature_of(mesh), bpy.context.scene
    bones, data = armature.pose.bones, armature.animation_data
    playing, before = data and data.action, [bone.matrix_basis.copy() for bone in bones]
    try:
        if action:
            show_action(armature, action)
        elif playing:
            data.action = None
        for bone in bones if action is None else ():
            own, turn = bone.bone.matrix_local.to_3x3(), ARMS_DOWN.get(bone.name, 0.0)
            bone.matrix_basis = (own.inverted() @ Matrix.Rotation(turn, 3, "Y") @ own).to_4x4()
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        yield
    finally:
        if data := armature.animation_data:
            data.action = None
        for bone, basis in zip(bones, before, strict=True):
            bone.matrix_basis = basis
        if playing:
            show_action(armature, playing)
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)


def shown_surface(items: Sequence[bpy.types.Object]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (V, 3) in the world, triangles (F, 3) and sRGB colours (V, 3) of objects as they are now."""
    depsgraph, points, faces, colours, count = bpy.context.evaluated_depsgraph_get(), [], [], [], 0
    for item in items:
        shown = item.evaluated_get(depsgraph)
        vertices, painted = shown.data.vertices, shown.data.color_attributes.active_color
        size = len(vertices)
        own = read_values(vertices, "co", 3 * size, np.float32).reshape(size, 3)
        points.append(moved(own.astype(float), matrix(shown.matrix_world)))
        faces.append(triangles_of(shown.data) + count)
        colours.append(np.tile(CLOTH, (size, 1)))
        if painted is not None and painted.domain == "POINT":
            colours[-1] = painted_colours(painted)
        count += size
    return np.concatenate(points), np.concatenate(faces), np.concatenate(colours)


def show_picture(path: Path, drawn_after: float) -> None:
    """Show a picture whole in a window of its own, which is drawn so many seconds after it opens."""
    windows = bpy.context.window_manager.windows
    image = bpy.data.images.load(str(path), check_existing=True)
    image.reload()
    with bpy.context.temp_override(window=windows[0]):
        bpy.ops.wm.window_new()
    window = windows[-1]
    area = window.screen.areas[0]
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = image

    def show_whole() -> None:
        if window in windows[:]:
            region = next(each for each in area.regions if each.type == "WINDOW")
            with bpy.context.temp_override(window=window, area=area, region=region):
                bpy.ops.image.view_all(fit_view=True)

    bpy.app.timers.register(show_whole, first_interval=drawn_after)


def room_of(item: bpy.types.Object, frames: np.ndarray) -> Generator[float, None, tuple[np.ndarray, float]]:
    """Centres (N, 3) of views that go with an object along the ground, and the width that shows it whole.

    The object is looked at in each of the scene's frames (N,); yields the share that is done.
    """
    seen: list[tuple[float, ...]] = []
    distinct, place = np.unique(frames, return_inverse=True)
    for number in each_frame(distinct):
        points = shown_surface([item])[0]
        middle = points.mean(axis=0)
        reach = np.linalg.norm((points - middle)[:, :2], axis=1).max()
        seen.append((*middle[:2], reach, points[:, 2].min(), points[:, 2].max()))
        yield number / len(distinct)
    x, y, reach, low, high = np.array(seen)[place].T
    height = np.full(len(frames), (low.min() + high.max()) / 2)
    return np.column_stack([x, y, height]), float(max(2 * reach.max(), high.max() - low.min()))
