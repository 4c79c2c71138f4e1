# SPDX-License-Identifier: GPL-3.0-or-later
"""A coarse double of a body for cloth to lie on while it is simulated: contact takes most of the time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .cloth import COLLIDER

FACES = 4000
"""Triangles of the double, about; a body that has no more serves itself."""

KEPT = ("thickness_outer", "thickness_inner", "cloth_friction", "damping", "use_culling", "use_normal")
"""Settings of a collider that cloth feels."""


@contextmanager
def coarse_collider(mesh: bpy.types.Object) -> Iterator[None]:
    """Let cloth lie on a coarse double of a body, where W2W made it a collider and bones alone move it."""
    own = mesh.modifiers.get(COLLIDER)
    if own is None or not _plain(mesh) or len(mesh.data.polygons) <= FACES:
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


def _plain(mesh: bpy.types.Object) -> bool:
    """Whether a double that has the armature alone moves as the mesh does."""
    kinds = [modifier.type for modifier in mesh.modifiers if modifier.show_viewport]
    animated = mesh.data.shape_keys is not None or mesh.animation_data is not None
    return sorted(kinds) == ["ARMATURE", "COLLISION"] and not animated


def _double(mesh: bpy.types.Object) -> bpy.types.Object:
    """The mesh with fewer triangles, weighted as it is."""
    double = mesh.copy()
    mesh.users_collection[0].objects.link(double)
    rig = next(modifier.object for modifier in double.modifiers if modifier.type == "ARMATURE")
    double.modifiers.clear()
    double.modifiers.new("Decimate", "DECIMATE").ratio = FACES / len(mesh.data.polygons)
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
