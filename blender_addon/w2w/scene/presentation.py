# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a posed body as Blender renders it: evenly lit, from a camera of its own, on nothing."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from mathutils import Vector
from PIL import Image

from ..core.body.skeleton import JOINT_NAMES
from .base.body import armature_of, matrix
from .base.module import bpy

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
def stage(items: Sequence[bpy.types.Object], size: int) -> Iterator[Callable[..., np.ndarray]]:
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
    shading.light, shading.color_type, shading.show_cavity = "STUDIO", "VERTEX", True
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
