# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W's own T-shirt and trousers in the scene: cut for the body, moved by Blender's cloth."""

from __future__ import annotations

import bpy
import numpy as np

from ...core.body.body import Body
from ...core.garments.cut import Garment, cut
from ..body import add_skinned, armature_of, body_of, reskin, rest_vertices

KIND = "w2w garment"
"""Custom property of a garment of ours: which one it is."""

NAMES = {"tshirt": "T-Shirt", "trousers": "Trousers"}

HELD = "W2W held"
"""Vertex group of the cloth at collar or waistband, which goes with the skin."""

CLOTH = "Cloth"
"""Modifier that moves a garment of ours."""

AS_CUT = 1e-5
"""How far vertices may be from where they were cut and still count as there, metres."""

COTTON = {
    "quality": 5,
    "mass": 0.3,
    "air_damping": 1.0,
    "tension_stiffness": 15.0,
    "compression_stiffness": 15.0,
    "shear_stiffness": 15.0,
    "bending_stiffness": 0.5,
    "tension_damping": 5.0,
    "compression_damping": 5.0,
    "shear_damping": 5.0,
    "bending_damping": 0.5,
}
"""As Blender's own preset for cotton."""

COLLISION_STEPS, CLOTH_GAP, SKIN_GAP = 4, 0.004, 0.004
"""Passes of collision a step; how far cloth and skin stay apart, metres: the sum of both."""

FRICTION = 60.0
"""Of cloth on a body, in hundredths: cotton slides on skin at 0.25 (forearm) to 0.79 (chest)."""

COLLIDER = "W2W collision"
"""Modifier of a body that cloth lies on."""


def dress(mesh: bpy.types.Object, kind: str) -> bpy.types.Object:
    """Add a T-shirt or trousers to a body's scene, cut for the body as it is.

    Parameters
    ----------
    mesh : Object
        The body's mesh.
    kind : str
        One of `garments.KINDS`.

    Returns
    -------
    Object
        Moved by the body's armature, then by cloth.

    Raises
    ------
    ValueError
        If there is no such garment, or the mesh is no body.
    """
    body, armature = body_of(mesh), armature_of(mesh)
    garment = cut(kind, body)
    home = mesh.users_collection[0] if mesh.users_collection else bpy.context.scene.collection
    item = add_skinned(_in_armature(garment.cloth, armature), armature, home, NAMES[kind])
    item[KIND] = kind
    _make_cloth(item, garment)
    lie_on(mesh)
    return item


def lie_on(mesh: bpy.types.Object) -> None:
    """Let cloth lie on a mesh."""
    if not any(modifier.type == "COLLISION" for modifier in mesh.modifiers):
        mesh.modifiers.new(COLLIDER, "COLLISION")
        mesh.collision.thickness_outer = SKIN_GAP
        mesh.collision.cloth_friction = FRICTION


def lies_on_nothing(mesh: bpy.types.Object) -> None:
    """Take away what `lie_on` gave a mesh."""
    modifier = mesh.modifiers.get(COLLIDER)
    if modifier is not None:
        mesh.modifiers.remove(modifier)


def refit(item: bpy.types.Object, mesh: bpy.types.Object, garment: Garment) -> None:
    """Give a garment of ours the mesh cut for the body as it is, where it was cut for another shape."""
    cloth = _in_armature(garment.cloth, armature_of(mesh))
    own = rest_vertices(item)
    if own.shape == cloth.vertices.shape and np.abs(own - cloth.vertices).max() < AS_CUT:
        return
    reskin(item, cloth)
    _hold(item, garment)


def _in_armature(cloth: Body, armature: bpy.types.Object) -> Body:
    """A garment in its armature's own units; the body is in metres."""
    scale = np.linalg.norm(np.array(armature.matrix_world, dtype=np.float64)[:3, :3], axis=0)
    return Body(cloth.vertices / scale, cloth.faces, cloth.joints, cloth.weights, cloth.name)


def _make_cloth(item: bpy.types.Object, garment: Garment) -> None:
    modifier = item.modifiers.new(CLOTH, "CLOTH")
    for name, value in COTTON.items():
        setattr(modifier.settings, name, value)
    collision = modifier.collision_settings
    collision.use_collision = True
    collision.collision_quality = COLLISION_STEPS
    collision.distance_min = CLOTH_GAP
    collision.use_self_collision = False
    _hold(item, garment)


def _hold(item: bpy.types.Object, garment: Garment) -> None:
    """Pin what the skin holds."""
    item.vertex_groups.new(name=HELD).add(np.flatnonzero(garment.held).tolist(), 1.0, "REPLACE")
    if CLOTH in item.modifiers:
        item.modifiers[CLOTH].settings.vertex_group_mass = HELD
