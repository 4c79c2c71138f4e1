# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a posed body as Blender renders it: evenly lit, from a camera of its own, on nothing."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from mathutils import Matrix, Vector
from PIL import Image

from ..core.body.skeleton import JOINT_NAMES
from .base.actions import show_action
from .base.body import armature_of, matrix
from .base.module import bpy

ARMS_DOWN = {"left_shoulder": np.radians(62), "right_shoulder": np.radians(-62)}
"""Turns about the axis from back to front of the bones that hang in a neutral pose, radians."""

AWAY = 10.0
"""Distance of the camera, in widths of its picture."""


def facing(mesh: bpy.types.Object) -> float:
    """Turn about z, radians, of the way that a body's hips face now; 0 is along -y."""
    armature = armature_of(mesh)
    pelvis = armature.pose.bones[JOINT_NAMES[0]]
    turned = matrix(armature.matrix_world @ pelvis.matrix @ pelvis.bone.matrix_local.inverted())
    x, y, _ = -turned[:3, 1]
    return float(np.arctan2(x, -y))


@contextmanager
def neutral(mesh: bpy.types.Object) -> Iterator[None]:
    """Inside, a body stands upright with its arms down; its clip and its pose come back at the end."""
    armature, scene = armature_of(mesh), bpy.context.scene
    bones, data = armature.pose.bones, armature.animation_data
    action, before = data and data.action, [bone.matrix_basis.copy() for bone in bones]
    try:
        if action:
            data.action = None
        for bone in bones:
            own, turn = bone.bone.matrix_local.to_3x3(), ARMS_DOWN.get(bone.name, 0.0)
            bone.matrix_basis = (own.inverted() @ Matrix.Rotation(turn, 3, "Y") @ own).to_4x4()
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        yield
    finally:
        for bone, basis in zip(bones, before, strict=True):
            bone.matrix_basis = basis
        if action:
            show_action(armature, action)
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)


@contextmanager
def stage(
    items: Sequence[bpy.types.Object], size: int, light: str = "STUDIO"
) -> Iterator[Callable[..., np.ndarray]]:
    """A scene of its own that holds objects as they are now.

    It gives a function that renders it as seen from a direction (3,), a `width` in metres around a centre
    (3,), as a picture (size, size, 4), uint8, with straight alpha.
    """
    shown, scene = bpy.context.scene, bpy.data.scenes.new("W2W Presentation")
    camera = bpy.data.objects.new("W2W Presentation", bpy.data.cameras.new("W2W Presentation"))
    for item in (camera, *items):
        scene.collection.objects.link(item)
    scene.camera, camera.data.type = camera, "ORTHO"
    render, shading = scene.render, scene.display.shading
    render.engine, render.film_transparent = "BLENDER_WORKBENCH", True
    render.image_settings.color_mode = "RGBA"
    render.resolution_x = render.resolution_y = size
    render.fps, render.fps_base = shown.render.fps, shown.render.fps_base
    shading.light, shading.color_type = light, "VERTEX"
    scene.view_settings.view_transform = "Standard"
    scene.frame_set(shown.frame_current, subframe=shown.frame_subframe)

    def picture(towards: np.ndarray, centre: np.ndarray, width: float) -> np.ndarray:
        camera.data.ortho_scale, camera.data.clip_end = width, 2 * AWAY * width
        camera.location = Vector(centre + AWAY * width * np.asarray(towards))
        camera.rotation_euler = Vector(towards).to_track_quat("Z", "Y").to_euler()
        with tempfile.TemporaryDirectory(prefix="w2w_render_") as folder:
            render.filepath = str(Path(folder) / "view.png")
            bpy.ops.render.render(write_still=True, scene=scene.name)
            with Image.open(render.filepath) as drawn:
                return np.array(drawn.convert("RGBA"))

    try:
        yield picture
    finally:
        data = camera.data
        bpy.data.scenes.remove(scene)
        bpy.data.batch_remove([camera, data])
