# SPDX-License-Identifier: GPL-3.0-or-later
"""Where patches are in a 3D view, on the surface as it is now, and whether the body hides them."""

from __future__ import annotations

import bpy
from bpy_extras.view3d_utils import (
    location_3d_to_region_2d,
    region_2d_to_origin_3d,
    region_2d_to_vector_3d,
)
from mathutils import Vector

from ..core.patches.patches import PatchSet
from ..scene.patches import empties_by_patch

SKIN = 0.01
"""Metres that a ray may end before a patch and still see it: triangles lean."""


class Surface:
    """A body's evaluated surface in the 3D view that is being drawn.

    Parameters
    ----------
    context : Context
    body : Object
    patches : PatchSet
    """

    def __init__(self, context: bpy.types.Context, body: bpy.types.Object, patches: PatchSet) -> None:
        self._region, self._view = context.region, context.region_data
        self._depsgraph = context.view_layer.depsgraph
        self._body, self._patches = body, patches
        self._evaluated = body.evaluated_get(self._depsgraph)
        self._whole = len(self._evaluated.data.vertices) == len(patches.labels)
        """Whether the mesh has the vertices that patches know; modifiers may have made others."""

    def on_screen(self, patch: int) -> Vector | None:
        """Where a patch is in the region, pixels; None behind the viewer, or where nothing tells."""
        return self._on_screen(self._place(patch))

    def in_sight(self, patch: int) -> bool:
        """Whether no part of the body stands between the viewer and the patch."""
        return self._in_sight(self._place(patch))

    def spot(self, vertex: int) -> Vector | None:
        """Where a vertex is in the region, pixels; None where it is out of sight, or nothing tells."""
        known = self._whole and 0 <= vertex < len(self._patches.labels)
        place = self._corner(vertex) if known else None
        return self._on_screen(place) if self._in_sight(place) else None

    def _on_screen(self, place: Vector | None) -> Vector | None:
        return None if place is None else location_3d_to_region_2d(self._region, self._view, place)

    def _in_sight(self, place: Vector | None) -> bool:
        point = self._on_screen(place)
        if place is None or point is None:
            return False
        origin = region_2d_to_origin_3d(self._region, self._view, point)
        direction = region_2d_to_vector_3d(self._region, self._view, point)
        inverse = self._evaluated.matrix_world.inverted_safe()
        start = inverse @ origin
        hit, found, _, _ = self._evaluated.ray_cast(start, (inverse @ (origin + direction)) - start)
        if not hit:
            return True
        return ((self._evaluated.matrix_world @ found) - place).dot(direction) > -SKIN

    def _corner(self, vertex: int) -> Vector:
        """Where a vertex is in the world."""
        return self._evaluated.matrix_world @ self._evaluated.data.vertices[vertex].co

    def _place(self, patch: int) -> Vector | None:
        """Where a patch is in the world."""
        if self._whole:
            vertices = self._evaluated.data.vertices
            corners = [vertices[vertex].co for vertex in self._patches.triangles[patch].tolist()]
            return self._evaluated.matrix_world @ (sum(corners, Vector()) / 3)
        collection = self._body.w2w.patch_collection
        empty = None if collection is None else empties_by_patch(collection).get(patch)
        if empty is None or not empty.visible_get():
            return None
        return empty.evaluated_get(self._depsgraph).matrix_world.translation.copy()
