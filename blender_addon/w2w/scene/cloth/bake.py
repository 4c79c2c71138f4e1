# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments on a body: which can be worn, which patches they cover, and where the sensors on cloth go."""

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...core.body.body import JOINT_NAMES, Body
from ...core.garments.cut import split_name
from ...core.imu.cover import ClothSensors, Cover, RestLengths, caught_sentence, cover, without_overlap
from ...core.motion.motion import Motion
from ...core.motion.run_up import POSE_S, SETTLE_S, with_run_up
from ...core.motion.skinning import patch_matrices
from ...core.patches.patches import PatchSet
from ...core.wording import restated
from ..bake import Bake, PatchBaker, moved_besides_bones, placed
from ..base.actions import FIRST_FRAME, bone_curves, frames_of, key_rate, scene_rate, write_action
from ..base.body import (
    BodyObjects,
    add_body,
    armature_of,
    body_of,
    in_body_space,
    matrix,
    read_values,
    rest_vertices,
    triangles_of,
)
from ..base.module import bpy
from ..base.playback import (
    EvaluatedVertices,
    active_action,
    at_rate,
    each_frame,
    kept,
    playing,
    without_empties,
)
from ..base.steps import scaled, without_pauses
from ..motion.takes import existing_data, new_data
from .clear import clear_reach, with_clear_arms
from .garments import KIND, coarse_collider, dress, lie_on, real_time_speed


class DressedBody(NamedTuple):
    """A body's mesh, its garments and what each covers."""

    mesh: bpy.types.Object
    garments: Sequence[bpy.types.Object]
    covers: Sequence[Cover]


def follow(worn: DressedBody, motion: Motion, patches: PatchSet) -> Generator[float, None, ClothSensors]:
    """Let garments follow a body through a motion in its armature's space, settled before it begins.

    Where one is ours, the body's arms are held clear of its trunk meanwhile; the sensors are then carried
    back with the skin below them. Yields the share of the frames done. Between these pauses the scene is on
    another frame; at the end, or when the generator is closed early, it is as it was. Raises `ValueError` if
    the cloth flies apart.
    """
    body, armature = body_of(worn.mesh), armature_of(worn.mesh)
    ours = any(KIND in item for item in worn.garments)
    cleared = with_clear_arms(body, motion) if ours else motion
    reach = clear_reach(body, cleared)
    moved, before = with_run_up(cleared, reach)
    with ExitStack() as stack:
        stack.enter_context(at_rate(moved.rate))
        action = write_action(armature, moved, "W2W run-up")
        stack.callback(bpy.data.actions.remove, action)
        stack.enter_context(playing(armature, action))
        frames = int(FIRST_FRAME) + np.arange(moved.n_frames)
        on_cloth = yield from _settled(worn, frames, before, moved.rate)
    if not ours:
        return on_cloth
    poses = []
    for whole in (moved, with_run_up(motion, reach)[0]):
        clip = replace(whole, rotations=whole.rotations[before:], pelvis=whole.pelvis[before:])
        poses.append(patch_matrices(body, patches.triangles[on_cloth.patches], placed(clip, armature)))
    return on_cloth.carried(*poses)


def follow_scene(
    worn: DressedBody, action: bpy.types.Action | None, n_frames: int, rate: float
) -> Generator[float, None, ClothSensors]:
    """Like `follow`, for bodies moved by more than bones: the first pose is held while cloth settles.

    `n_frames` and `rate` are the clip's; the scene is played at the rate of the action's keys.
    """
    armature = armature_of(worn.mesh)
    first = bpy.context.scene.frame_start
    if action is not None and (curves := bone_curves(armature, action)):
        first = int(np.floor(frames_of(action, curves)[0][0]))
    per_second = key_rate(action)
    count = int(np.ceil(n_frames * per_second / rate)) + 1
    before = round((POSE_S + SETTLE_S) * per_second)
    with at_rate(per_second), playing(armature, action):
        return (yield from _settled(worn, np.arange(first - before, first + count), before, per_second))


def _settled(
    worn: DressedBody, frames: np.ndarray, before: int, rate: float
) -> Generator[float, None, ClothSensors]:
    """Garments through frames of the scene, in the first of which cloth only settles."""
    with ExitStack() as stack:
        stack.enter_context(without_empties(worn.mesh))
        stack.enter_context(coarse_collider(worn.mesh))
        for item in worn.garments:
            stack.enter_context(_simulated_over(item, frames, scene_rate()))
        pairs = zip(worn.garments, worn.covers, strict=True)
        followed = [SensorTriangles(item, own, len(frames) - before) for item, own in pairs]
        with closing(each_frame(frames)) as numbers:
            for number in numbers:
                if number >= before:
                    for triangles in followed:
                        triangles.take(number - before)
                yield (number + 1) / len(frames)
    carriers = zip(worn.covers, followed, strict=True)
    matrices = [cover.matrices(triangles.corners) for cover, triangles in carriers]
    patches = np.concatenate([cover.patches for cover in worn.covers])
    caught = {item.name: own.caught for item, own in zip(worn.garments, followed, strict=True)}
    return ClothSensors(patches, np.concatenate(matrices, axis=1), rate, caught)


@contextmanager
def _simulated_over(item: bpy.types.Object, frames: np.ndarray, rate: float) -> Iterator[None]:
    """Let physics run over these frames, cloth in real time; at the end as they were set before."""
    caches = [modifier.point_cache for modifier in simulated(item)]
    cloths = [modifier.settings for modifier in item.modifiers if modifier.type == "CLOTH"]
    before = [(cache, "frame_start", "frame_end") for cache in caches]
    with kept(*before, *((settings, "time_scale") for settings in cloths)):
        for cache in caches:
            cache.frame_start, cache.frame_end = int(frames[0]), int(frames[-1])
        for settings in cloths:
            settings.time_scale = real_time_speed(settings.time_scale, rate, settings.quality)
        yield


def simulated(item: bpy.types.Object) -> list[bpy.types.Modifier]:
    """Modifiers that simulate from frame to frame."""
    return [modifier for modifier in item.modifiers if getattr(modifier, "point_cache", None) is not None]


class SensorTriangles:
    """Corners of the triangles that carry a garment's sensors, and the frames in which its cloth was caught.

    Attributes
    ----------
    corners : ndarray, shape (n_frames, K, 3, 3)
    caught : int
        Number of these frames; 0 for a garment that is not simulated.
    """

    def __init__(self, item: bpy.types.Object, own: Cover, n_frames: int) -> None:
        self.corners = np.empty((n_frames, *own.triangles.shape, 3))
        self.caught = 0
        self._item, self._own = item, own
        self._vertices = EvaluatedVertices(item, own.triangles)
        self._lengths = None
        if simulated(item):
            edges = read_values(item.data.edges, "vertices", 2 * len(item.data.edges), np.int32)
            points = rest_vertices(item) @ matrix(item.matrix_world)[:3, :3].T
            self._lengths = RestLengths(points, edges.reshape(-1, 2))

    def take(self, number: int) -> None:
        """Read the scene's frame as this frame of the clip; a `ValueError` if the cloth has flown apart."""
        if self._lengths is None:
            self.corners[number] = self._vertices.positions()
        else:
            points = self._vertices.everywhere()
            self.corners[number] = points[self._own.triangles]
            self.caught += self._lengths.caught(points)
        points = self.corners[number].reshape(-1, 3)
        if not len(points):
            return
        # it has if a sensor is more than 3 m from the middle of all
        if not np.isfinite(points).all() or np.abs(points - np.median(points, axis=0)).max() > 3.0:
            raise ValueError(
                f"the cloth of '{self._item.name}' flew apart in this clip: raise the quality steps of its "
                "cloth, or take it off"
            )


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
    if any(modifier.point_cache.is_baked for modifier in simulated(item)):
        raise ValueError(
            f"the physics of '{item.name}' are baked, so that it would move as in another clip: press "
            "Delete Bake in its Cache panel"
        )


def cover_of(item: bpy.types.Object, mesh: bpy.types.Object, patches: PatchSet) -> Cover:
    """The patches of a body that a garment covers, both at rest; a `ValueError` if it covers none."""
    found = cover(*around_body(item, mesh), body_of(mesh), patches)
    refuse_bare(item, mesh, found)
    return found


def around_body(item: bpy.types.Object, mesh: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """A garment's vertices (V, 3) in the space of a body, at rest, metres, and its triangles (F, 3)."""
    return in_body_space(item, armature_of(mesh)), triangles_of(item.data)


def refuse_bare(item: bpy.types.Object, mesh: bpy.types.Object, found: Cover) -> None:
    """Refuse a garment that covers no patch."""
    if not len(found):
        raise ValueError(
            f"'{item.name}' covers no patch of '{mesh.name}': it must be around the body in its rest pose"
        )


class GarmentBaker:
    """Bakes the patches of a body of which some are covered by garments, action by action.

    The outer garment comes first; `covers` says what each covers. A body that cannot be baked is refused.
    """

    def __init__(
        self,
        mesh: bpy.types.Object,
        patches: PatchSet,
        garments: Sequence[bpy.types.Object],
        covers: Sequence[Cover],
    ) -> None:
        self.patches = patches
        self.worn = DressedBody(mesh, garments, without_overlap(covers))
        self._skin = PatchBaker(mesh, patches)

    def by_frame(self, action: bpy.types.Action | None = None) -> Generator[float, None, Bake]:
        """Bake as `PatchBaker.by_frame` does, then let the garments follow; a pause after each frame."""
        skin = yield from scaled(self._skin.by_frame(action), 0.0, 0.1)
        action = action or active_action(armature_of(self.worn.mesh))
        if skin.motion is not None and not moved_besides_bones(self.worn.mesh, action):
            frames = follow(self.worn, skin.motion, self.patches)
        else:
            frames = follow_scene(self.worn, action, skin.n_frames, skin.rate)
        on_cloth = yield from scaled(frames, 0.1, 1.0)
        reason = f"{len(on_cloth.patches)} sensors are on {', '.join(on_cloth.caught)}"
        if caught := caught_sentence(on_cloth.caught, len(on_cloth.matrices)):
            reason += f"; {caught}"
        return replace(skin, path="general", reason=reason, on_cloth=on_cloth)


def fitted(garment: str, body: Body, patches: PatchSet) -> Cover:
    """The patches of a body that a garment covers; a `ValueError` if it cannot be worn or covers none."""
    with _dressed(body, (garment,)) as (objects, (item,)):
        check_garment(item, objects.mesh)
        return cover_of(item, objects.mesh, patches)


def followed(body: Body, patches: PatchSet, covers: Mapping[str, Cover], motion: Motion) -> ClothSensors:
    """The places of the sensors on garments while a body moves, from each garment's cover, by its name.

    Raises `ValueError` if a garment cannot be worn, or its cloth flies apart.
    """
    with _dressed(body, tuple(covers)) as (objects, garments):
        worn = DressedBody(objects.mesh, garments, tuple(covers.values()))
        found = without_pauses(follow(worn, motion, patches))
        return replace(found, caught=dict(zip(covers, found.caught.values(), strict=True)))


@contextmanager
def _dressed(body: Body, garments: tuple[str, ...]) -> Iterator[tuple[BodyObjects, list[bpy.types.Object]]]:
    """A body and its garments in the open scene, removed again at the end."""
    before = existing_data()
    libraries = set(bpy.data.libraries)
    try:
        objects = add_body(body)
        items = []
        for garment in garments:
            file, name = split_name(garment)
            items.append(put_on(file, name, objects) if file else dress(objects.mesh, name))
        yield objects, items
    finally:
        bpy.data.batch_remove(new_data(before))
        bpy.data.batch_remove([item for item in bpy.data.libraries if item not in libraries])


def put_on(path: str | Path, name: str, objects: BodyObjects) -> bpy.types.Object:
    """Append a garment from a .blend file and let it follow this body instead of the one in its file.

    Its dependencies come along: lattices, other meshes. An armature with the bones of a body becomes this
    body's; so does the mesh of the same body. Raises `ValueError` if the file cannot be read, does not hold
    the garment, or it follows no body there.
    """
    before = existing_data()
    garment = _append(Path(path), name)
    came = [item for item in new_data(before) if isinstance(item, bpy.types.Object)]
    n_vertices = len(objects.mesh.data.vertices)
    meshes = [item for item in came if item.type == "MESH" and item is not garment]
    bodies = [item for item in meshes if len(item.data.vertices) == n_vertices]
    armatures = [item for item in came if item.type == "ARMATURE"]
    rigs = [item for item in armatures if set(JOINT_NAMES) <= set(item.data.bones.keys())]
    if not rigs:
        raise ValueError(
            f"'{name}' in {path} follows no body: in that file let it follow a body that Add Body made, by "
            "its armature or its mesh"
        )
    for theirs, ours in ((bodies, objects.mesh), (rigs, objects.armature)):
        for item in theirs:
            item.user_remap(ours)
    home = objects.mesh.users_collection[0]
    for item in came:
        if item not in bodies and item not in rigs:
            home.objects.link(item)
    if any(modifier.type == "CLOTH" for modifier in garment.modifiers):
        lie_on(objects.mesh)
    bpy.context.view_layer.update()
    return garment


def _append(path: Path, name: str) -> bpy.types.Object:
    unreadable = restated(f"{path} cannot be read as a .blend file:", OSError)
    with unreadable, bpy.data.libraries.load(str(path), link=False) as (held, wanted):
        names = list(held.objects)
        wanted.objects = [name] if name in names else []
    if name not in names:
        known = ", ".join(sorted(names)[:12]) or "none"
        raise ValueError(f"{path} holds no object '{name}'; its objects are: {known}")
    found = wanted.objects[0]
    if found is None:
        raise ValueError(f"'{name}' cannot be read from {path}: the file is damaged")
    return found
