# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes patches of which garments cover some: which these are, and where the sensors on cloth go."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace

import bpy
import numpy as np

from ...core.garments.caught import caught_sentence
from ...core.garments.cover import Cover, cover, without_overlap
from ...core.patches.patches import PatchSet
from ..bake import Bake, PatchBaker, moved_besides_bones
from ..base.body import armature_of, body_of, body_space, matrix, rest_vertices, triangles_of
from ..base.playback import active_action
from ..base.steps import scaled
from .follow import follow, follow_scene, simulated

TIED = ("ARMATURE", "CLOTH", "SOFT_BODY", "SURFACE_DEFORM", "SHRINKWRAP", "LATTICE", "MESH_DEFORM", "NODES",
        "HOOK", "CAST", "MESH_CACHE", "MESH_SEQUENCE_CACHE")  # fmt: skip
"""Modifiers by which a mesh may follow a body."""


def check_garment(item: bpy.types.Object, mesh: bpy.types.Object) -> None:
    """Refuse an object that is no mesh, is the body itself, follows nothing or replays baked physics."""
    if item.type != "MESH" or not len(item.data.polygons):
        raise ValueError(f"'{item.name}' is no mesh with faces: choose the mesh of a garment")
    if item == mesh:
        raise ValueError(f"'{item.name}' is the body itself: choose the mesh of a garment")
    if item.parent is None and not any(modifier.type in TIED for modifier in item.modifiers):
        raise ValueError(
            f"'{item.name}' does not follow the body: give it a modifier that does (Armature, Cloth, Surface "
            "Deform, Shrinkwrap, Lattice), or parent it"
        )
    for modifier in simulated(item):
        if modifier.point_cache.is_baked:
            raise ValueError(
                f"the physics of '{item.name}' are baked, so that it would move as in another clip: press "
                "Delete Bake in its Cache panel"
            )


def cover_of(item: bpy.types.Object, mesh: bpy.types.Object, patches: PatchSet) -> Cover:
    """The patches of a body that a garment covers, both at rest; a `ValueError` where it covers none."""
    found = cover(*around_body(item, mesh), body_of(mesh), patches)
    refuse_bare(item, mesh, found)
    return found


def around_body(item: bpy.types.Object, mesh: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """A garment's vertices (V, 3) in the space of a body, at rest, metres, and its triangles (F, 3)."""
    armature = armature_of(mesh)
    to_body = body_space(armature) @ np.linalg.inv(matrix(armature.matrix_world)) @ matrix(item.matrix_world)
    return rest_vertices(item) @ to_body[:3, :3].T + to_body[:3, 3], triangles_of(item.data)


def refuse_bare(item: bpy.types.Object, mesh: bpy.types.Object, found: Cover) -> None:
    """Refuse a garment that covers no patch."""
    if not len(found):
        raise ValueError(
            f"'{item.name}' covers no patch of '{mesh.name}': it must be around the body in its rest pose"
        )


class GarmentBaker:
    """Bakes the patches of a body of which some are covered by garments, action by action.

    The outer garment comes first; `covers` says what each covers, where that is known. A body that cannot be
    baked, and a garment that cannot be used or covers nothing, is refused.
    """

    def __init__(
        self,
        mesh: bpy.types.Object,
        patches: PatchSet,
        garments: Sequence[bpy.types.Object],
        covers: Sequence[Cover] | None = None,
    ) -> None:
        self.mesh = mesh
        self.patches = patches
        self.garments = tuple(garments)
        self._skin = PatchBaker(mesh, patches)
        for item in garments:
            check_garment(item, mesh)
        found = [cover_of(item, mesh, patches) for item in garments] if covers is None else covers
        self.covers = without_overlap(found)

    def by_frame(self, action: bpy.types.Action | None = None) -> Generator[float, None, Bake]:
        """Bake as `PatchBaker.by_frame` does, then let the garments follow; a pause after each frame."""
        skin = yield from scaled(self._skin.by_frame(action), 0.0, 0.1)
        armature = armature_of(self.mesh)
        action = action or active_action(armature)
        worn = self.mesh, self.garments, self.covers
        if skin.motion is not None and not moved_besides_bones(self.mesh, armature, action):
            frames = follow(*worn, skin.motion, self.patches)
        else:
            frames = follow_scene(*worn, action, len(skin.matrices), skin.rate)
        on_cloth = yield from scaled(frames, 0.1, 1.0)
        names = [item.name for item in self.garments]
        reason = f"{len(on_cloth.patches)} sensors are on {', '.join(names)}"
        if caught := caught_sentence(dict(zip(names, on_cloth.caught, strict=True)), len(on_cloth.matrices)):
            reason += f"; {caught}"
        return replace(skin, path="general", reason=reason, on_cloth=on_cloth)
