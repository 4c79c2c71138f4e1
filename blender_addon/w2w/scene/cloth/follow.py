# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that follow a body through a clip, frame by frame, once their cloth has settled."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...core.imu.cover import Cover
from ...core.imu.on_cloth import ClothSensors, RestLengths
from ...core.motion.motion import Motion
from ...core.motion.run_up import POSE_S, SETTLE_S, with_run_up
from ...core.motion.skinning import patch_matrices
from ...core.patches.patches import PatchSet
from ..bake import placed
from ..base.actions import FIRST_FRAME, bone_curves, frames_of, key_rate, scene_rate, write_action
from ..base.body import armature_of, body_of, matrix, read_values, rest_vertices
from ..base.module import bpy
from ..base.playback import EvaluatedVertices, at_rate, each_frame, kept, playing, without_empties
from .clear import clear_reach, with_clear_arms
from .garments import KIND, coarse_collider, real_time_speed


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
