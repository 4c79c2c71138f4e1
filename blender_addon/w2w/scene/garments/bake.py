# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the sensors that garments carry, as Blender moves the garments with the body."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace

import bpy
import numpy as np

from ...core.garments.caught import caught_sentence
from ...core.garments.cover import Cover, cover, without_overlap
from ...core.garments.on_cloth import Worn
from ...core.garments.run_up import POSE_S, SETTLE_S, with_run_up
from ...core.motion.motion import Motion
from ...core.motion.skinning import patch_matrices
from ...core.patches.patches import PatchSet
from .. import actions
from ..actions import key_rate, scene_rate, write_action
from ..bake import Bake, PatchBaker, placed
from ..body import armature_of, body_of, body_space, matrix, rest_vertices, triangles_of
from ..fast_path import moved_besides_bones
from ..playback import active_action, at_rate, each_frame, playing, without_empties
from .clear_arms import with_clear_arms
from .clear_run_up import clear_reach
from .cloth import KIND
from .cloth_time import real_time_speed
from .collider import coarse_collider
from .followed import Followed, simulated

TIED = ("ARMATURE", "CLOTH", "SOFT_BODY", "SURFACE_DEFORM", "SHRINKWRAP", "LATTICE", "MESH_DEFORM", "NODES",
        "HOOK", "CAST", "MESH_CACHE", "MESH_SEQUENCE_CACHE")  # fmt: skip
"""Modifiers by which a mesh may follow a body."""


def check_garment(item: bpy.types.Object, mesh: bpy.types.Object) -> None:
    """Refuse what cannot be worn as a garment.

    Raises
    ------
    ValueError
        If it is no mesh, is the body itself, follows nothing, or replays baked physics.
    """
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
    """The patches of a body that a garment covers, both as they are at rest.

    Raises
    ------
    ValueError
        If it covers none.
    """
    found = cover(*around_body(item, mesh), body_of(mesh), patches)
    refuse_bare(item, mesh, found)
    return found


def around_body(item: bpy.types.Object, mesh: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """A garment's vertices (V, 3) in the space of a body, at rest, metres, and its triangles (F, 3)."""
    armature = armature_of(mesh)
    to_body = body_space(armature) @ np.linalg.inv(matrix(armature.matrix_world)) @ matrix(item.matrix_world)
    return rest_vertices(item) @ to_body[:3, :3].T + to_body[:3, 3], triangles_of(item.data)


def refuse_bare(item: bpy.types.Object, mesh: bpy.types.Object, found: Cover) -> None:
    """Refuse a garment that covers nothing.

    Raises
    ------
    ValueError
        If no patch is in its cover.
    """
    if not len(found):
        raise ValueError(
            f"'{item.name}' covers no patch of '{mesh.name}': it must be around the body in its rest pose"
        )


class GarmentBaker:
    """Bakes the patches of a body of which some are covered by garments, action by action.

    Parameters
    ----------
    mesh : Object
        The body's mesh.
    patches : PatchSet
    garments : sequence of Object
        The outer first.
    covers : sequence of Cover, optional
        What each covers, where that is known.

    Raises
    ------
    ValueError
        If the mesh is no body that can be baked, or a garment cannot be worn or covers nothing.
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
        skin = yield from _part(self._skin.by_frame(action), 0.0, 0.1)
        armature = armature_of(self.mesh)
        action = action or active_action(armature)
        besides = moved_besides_bones(self.mesh, armature, action)
        if skin.motion is not None and not besides:
            frames = follow(self.mesh, self.garments, self.covers, skin.motion, self.patches)
        else:
            frames = _follow_scene(
                self.mesh, self.garments, self.covers, action, len(skin.matrices), skin.rate
            )
        worn = yield from _part(frames, 0.1, 1.0)
        names = [item.name for item in self.garments]
        reason = f"{len(worn.patches)} sensors are on {', '.join(names)}"
        if caught := caught_sentence(dict(zip(names, worn.caught, strict=True)), len(worn.matrices)):
            reason += f"; {caught}"
        return replace(skin, path="general", reason=reason, worn=worn)


def follow(
    mesh: bpy.types.Object,
    garments: Sequence[bpy.types.Object],
    covers: Sequence[Cover],
    motion: Motion,
    patches: PatchSet,
) -> Generator[float, None, Worn]:
    """Let garments follow a body through a motion, from rest and settled before it begins.

    Where one is ours, the body's arms are held clear of its trunk meanwhile; the sensors are then
    carried back with the skin below them.

    The scene is on another frame between the pauses, and as it was at the end, or when the
    generator is closed early.

    Parameters
    ----------
    mesh : Object
        The body's.
    garments : sequence of Object
    covers : sequence of Cover
        One a garment.
    motion : Motion
        In the armature's space.
    patches : PatchSet
        Of the body.

    Yields
    ------
    float
        Share of the frames done.

    Raises
    ------
    ValueError
        If the cloth flies apart.
    """
    body, armature = body_of(mesh), armature_of(mesh)
    ours = any(KIND in item for item in garments)
    cleared = with_clear_arms(body, motion) if ours else motion
    reach = clear_reach(body, cleared)
    moved, before = with_run_up(cleared, reach)
    with ExitStack() as stack:
        stack.enter_context(at_rate(moved.rate))
        action = write_action(armature, moved, "W2W run-up")
        stack.callback(bpy.data.actions.remove, action)
        stack.enter_context(playing(armature, action))
        first = int(actions.FIRST_FRAME)
        frames = np.arange(first, first + moved.n_frames)
        followed = yield from _followed(stack, mesh, garments, covers, frames, before)
    worn = _worn(covers, followed, moved.rate)
    if not ours:
        return worn
    triangles = patches.triangles[worn.patches]
    there, here = (
        patch_matrices(body, triangles, placed(_from(one, before), armature))
        for one in (moved, with_run_up(motion, reach)[0])
    )
    return worn.carried(there, here)


def _from(motion: Motion, frame: int) -> Motion:
    return replace(motion, rotations=motion.rotations[frame:], pelvis=motion.pelvis[frame:])


def _follow_scene(
    mesh: bpy.types.Object,
    garments: Sequence[bpy.types.Object],
    covers: Sequence[Cover],
    action: bpy.types.Action | None,
    n_frames: int,
    rate: float,
) -> Generator[float, None, Worn]:
    """As `follow`, where more than bones moves the body: the first pose is held while cloth settles."""
    armature, scene = armature_of(mesh), bpy.context.scene
    first = scene.frame_start
    if action is not None and (curves := actions.bone_curves(armature, action)):
        first = int(np.floor(actions.frames_of(action, curves)[0][0]))
    per_second = key_rate(action)
    count = int(np.ceil(n_frames * per_second / rate)) + 1
    before = round((POSE_S + SETTLE_S) * per_second)
    with ExitStack() as stack:
        stack.enter_context(at_rate(per_second))
        stack.enter_context(playing(armature, action))
        frames = np.arange(first - before, first + count)
        followed = yield from _followed(stack, mesh, garments, covers, frames, before)
    return _worn(covers, followed, per_second)


def _followed(
    stack: ExitStack,
    mesh: bpy.types.Object,
    garments: Sequence[bpy.types.Object],
    covers: Sequence[Cover],
    frames: np.ndarray,
    before: int,
) -> Generator[float, None, list[Followed]]:
    """Each garment through the frames after the first ones."""
    stack.enter_context(without_empties(mesh))
    stack.enter_context(coarse_collider(mesh))
    for item in garments:
        stack.enter_context(_simulated_over(item, frames, scene_rate()))
    followed = [Followed(item, own, len(frames) - before) for item, own in zip(garments, covers, strict=True)]
    with closing(each_frame(frames)) as numbers:
        for number in numbers:
            if number >= before:
                for one in followed:
                    one.take(number - before)
            yield (number + 1) / len(frames)
    return followed


def _worn(covers: Sequence[Cover], followed: Sequence[Followed], rate: float) -> Worn:
    matrices = [own.matrices(one.corners) for own, one in zip(covers, followed, strict=True)]
    patches = np.concatenate([own.patches for own in covers])
    return Worn(patches, np.concatenate(matrices, axis=1), rate, tuple(one.caught for one in followed))


@contextmanager
def _simulated_over(item: bpy.types.Object, frames: np.ndarray, rate: float) -> Iterator[None]:
    """Let physics run over these frames, in real time where it is cloth; as they were at the end."""
    kept = []
    for modifier in simulated(item):
        cache = modifier.point_cache
        kept.append((cache, cache.frame_start, cache.frame_end))
        cache.frame_start, cache.frame_end = int(frames[0]), int(frames[-1])
    cloths = [modifier.settings for modifier in item.modifiers if modifier.type == "CLOTH"]
    speeds = [settings.time_scale for settings in cloths]
    for settings, speed in zip(cloths, speeds, strict=True):
        settings.time_scale = real_time_speed(speed, rate, settings.quality)
    try:
        yield
    finally:
        for cache, start, end in kept:
            cache.frame_start, cache.frame_end = start, end
        for settings, speed in zip(cloths, speeds, strict=True):
            settings.time_scale = speed


def _part(frames: Generator[float, None, Bake | Worn], low: float, high: float) -> Generator:
    """The shares of one piece of work as part of another."""
    with closing(frames):
        while True:
            try:
                share = next(frames)
            except StopIteration as stop:
                return stop.value
            yield low + (high - low) * share
