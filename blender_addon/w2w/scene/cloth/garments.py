# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W's own T-shirt and trousers in the scene, moved by Blender's cloth in real time over a coarse body.

Blender's cloth knows no time: its unit is a frame, and gravity is a thousandth of the scene's for each
frame squared. So it keeps real time at the root of 1,000 frames per second, and elsewhere only at a speed
set for the frame rate.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from ...core.body.body import Body
from ...core.garments.cut import Garment, cut
from ..base.body import add_skinned, armature_of, body_of, body_space, reskin, rest_vertices
from ..base.module import bpy

KIND = "w2w garment"
"""Custom property of a garment of ours: which one it is."""

NAMES = {"tshirt": "T-Shirt", "trousers": "Trousers"}

HELD = "W2W held"
"""Vertex group of the cloth at collar or waistband, which goes with the skin."""

CLOTH = "Cloth"
"""Modifier that moves a garment of ours."""

COTTON = {
    "quality": 5, "mass": 0.3, "air_damping": 1.0,
    "tension_stiffness": 15.0, "compression_stiffness": 15.0, "shear_stiffness": 15.0,
    "tension_damping": 5.0, "compression_damping": 5.0, "shear_damping": 5.0,
    "bending_stiffness": 0.5, "bending_damping": 0.5,
}  # fmt: skip
"""Blender's own preset for cotton."""

COLLISION_STEPS, CLOTH_GAP, SKIN_GAP = 4, 0.004, 0.004
"""Passes of collision a step; how far cloth and skin stay apart, metres: the sum of both."""

FRICTION = 60.0
"""Friction of cloth on a body, in hundredths: cotton slides on skin at 0.25 (forearm) to 0.79 (chest)."""

COLLIDER = "W2W collision"
"""Modifier of a body that cloth lies on."""

KEPT = ("thickness_outer", "thickness_inner", "cloth_friction", "damping", "use_culling", "use_normal")
"""Settings of a collider that cloth feels."""

COARSE_FACES = 4000
"""Triangles of the coarse body, about; a body with no more than that serves itself."""

REAL_TIME_RATE = math.sqrt(1000.0)
"""Frames per second at which cloth of speed 1 falls as things do."""


def dress(mesh: bpy.types.Object, kind: str) -> bpy.types.Object:
    """Add a garment, one of `KINDS`, cut for the body as it is; the armature moves it, then cloth.

    Raises `ValueError` if there is no such garment, or the mesh is no body.
    """
    body, armature = body_of(mesh), armature_of(mesh)
    garment = cut(kind, body)
    home = mesh.users_collection[0] if mesh.users_collection else bpy.context.scene.collection
    item = add_skinned(_in_armature(garment.cloth, armature), armature, home, NAMES[kind])
    item[KIND] = kind
    modifier = item.modifiers.new(CLOTH, "CLOTH")
    for name, value in COTTON.items():
        setattr(modifier.settings, name, value)
    collision = modifier.collision_settings
    collision.use_collision = True
    collision.collision_quality = COLLISION_STEPS
    collision.distance_min = CLOTH_GAP
    collision.use_self_collision = False
    _hold(item, garment)
    lie_on(mesh)
    return item


def lie_on(mesh: bpy.types.Object) -> None:
    """Let cloth lie on a mesh."""
    if not any(modifier.type == "COLLISION" for modifier in mesh.modifiers):
        _collide(mesh, {"thickness_outer": SKIN_GAP, "cloth_friction": FRICTION})


def lies_on_nothing(mesh: bpy.types.Object) -> None:
    """Take away what `lie_on` gave a mesh."""
    modifier = mesh.modifiers.get(COLLIDER)
    if modifier is not None:
        mesh.modifiers.remove(modifier)


def refit(item: bpy.types.Object, mesh: bpy.types.Object, garment: Garment) -> None:
    """Give a garment of ours a new mesh if it was cut for another shape of the body."""
    cloth = _in_armature(garment.cloth, armature_of(mesh))
    own = rest_vertices(item)
    if own.shape == cloth.vertices.shape and np.abs(own - cloth.vertices).max() < 1e-5:
        return
    reskin(item, cloth)
    _hold(item, garment)


@contextmanager
def coarse_collider(mesh: bpy.types.Object) -> Iterator[None]:
    """Let cloth lie on a coarse double of a body: contact takes most of the time.

    Only where W2W made the body a collider and bones alone move it.
    """
    own = mesh.modifiers.get(COLLIDER)
    shown = sorted(modifier.type for modifier in mesh.modifiers if modifier.show_viewport)
    animated = mesh.data.shape_keys is not None or mesh.animation_data is not None
    moved_by_bones_alone = shown == ["ARMATURE", "COLLISION"] and not animated
    if own is None or not moved_by_bones_alone or len(mesh.data.polygons) <= COARSE_FACES:
        yield
        return
    settings = {name: getattr(mesh.collision, name) for name in KEPT}
    double = _double(mesh)
    data = double.data
    try:
        mesh.modifiers.remove(own)
        _collide(double, settings)
        yield
    finally:
        bpy.data.objects.remove(double)
        bpy.data.meshes.remove(data)
        _collide(mesh, settings)


def real_time_speed(speed: float, rate: float, steps: int) -> float:
    """The speed at which cloth keeps time at a frame rate, with some steps of simulation each frame.

    A user's own speed stays in proportion. Blender adds steps up in single precision until they fill the
    frame, and where rounding leaves them short by a hair it makes one more, a tenth of the gravity too much
    at 20 steps: such speeds are passed over.
    """
    wanted = speed * REAL_TIME_RATE / rate
    nudged = wanted
    while _steps_made(nudged, steps) > steps:
        nudged += 1e-6 * wanted
    return nudged


def _in_armature(cloth: Body, armature: bpy.types.Object) -> Body:
    """A garment in its armature's own units; the body is in metres."""
    return replace(cloth, vertices=cloth.vertices / np.diag(body_space(armature))[:3])


def _hold(item: bpy.types.Object, garment: Garment) -> None:
    """Pin what the skin holds."""
    item.vertex_groups.new(name=HELD).add(np.flatnonzero(garment.held).tolist(), 1.0, "REPLACE")
    if CLOTH in item.modifiers:
        item.modifiers[CLOTH].settings.vertex_group_mass = HELD


def _double(mesh: bpy.types.Object) -> bpy.types.Object:
    """The mesh with fewer triangles and the same weights."""
    double = mesh.copy()
    mesh.users_collection[0].objects.link(double)
    rig = next(modifier.object for modifier in double.modifiers if modifier.type == "ARMATURE")
    double.modifiers.clear()
    double.modifiers.new("Decimate", "DECIMATE").ratio = COARSE_FACES / len(mesh.data.polygons)
    view = bpy.context.evaluated_depsgraph_get()
    data = bpy.data.meshes.new_from_object(
        double.evaluated_get(view), preserve_all_data_layers=True, depsgraph=view
    )
    double.modifiers.clear()
    double.data = data
    double.modifiers.new("Armature", "ARMATURE").object = rig
    double.hide_render = True
    return double


def _collide(item: bpy.types.Object, settings: dict[str, object]) -> None:
    item.modifiers.new(COLLIDER, "COLLISION")
    for name, value in settings.items():
        setattr(item.collision, name, value)


def _steps_made(speed: float, steps: int) -> int:
    """Steps that Blender makes of a frame, counted as it counts them."""
    frame = np.float32(speed)
    step = np.float32(1) / np.float32(steps) * frame
    done, count = np.float32(0), 0
    while done < frame:
        done += step
        count += 1
    return count
