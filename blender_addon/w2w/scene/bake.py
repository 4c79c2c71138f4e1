# SPDX-License-Identifier: GPL-3.0-or-later
"""World matrices of patches from what is in the scene: fast from f-curves, or as Blender evaluates it."""

from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np

from ..core.body.body import JOINT_NAMES, PARENTS, Body
from ..core.imu.cover import ClothSensors
from ..core.motion.motion import Motion
from ..core.motion.skinning import patch_matrices, triangle_frames
from ..core.patches.patches import PatchSet
from .base import actions
from .base.body import armature_of, body_of, body_space, matrix, with_parents
from .base.module import bpy
from .base.patches import check_patches
from .base.playback import EvaluatedVertices, active_action, at_rate, each_frame, playing, without_empties


@dataclass(frozen=True, eq=False)
class Bake:
    """The places of all patches in all frames.

    Parameters
    ----------
    pose : callable
        Works out `matrices` from what was read of the scene, in any thread.
    n_frames : int
        T.
    rate : float
        Frames per second.
    path : {"fast", "general"}
        From f-curves, or from Blender's evaluated mesh.
    reason : str
        Why that path, as a sentence for the person who waits.
    motion : Motion or None
        The action in the armature's space; None if it is more than a `Motion` can express.
    root : ndarray, shape (T, 3), or None
        Path of the root in the world; None on the general path, where more than the bones may move it.
    on_cloth : ClothSensors or None
        The sensors that sit on cloth; in `matrices` they are on the skin.
    """

    pose: Callable[[], np.ndarray]
    n_frames: int
    rate: float
    path: Literal["fast", "general"]
    reason: str
    motion: Motion | None
    root: np.ndarray | None = None
    on_cloth: ClothSensors | None = None

    @cached_property
    def matrices(self) -> np.ndarray:
        """World matrices of the patches' frames, shape (T, N, 4, 4), float64, metres, without scale."""
        return self.pose()


class PatchBaker:
    """Bakes the patches of one body, action by action.

    A mesh that is no body, is scaled unevenly or mirrored, and patches of another body are refused.
    """

    def __init__(self, mesh: bpy.types.Object, patches: PatchSet) -> None:
        self.mesh = mesh
        self.patches = patches
        self.armature = armature_of(mesh)
        check_patches(mesh, patches)
        if not _is_even(mesh):
            raise ValueError(
                f"'{mesh.name}' is scaled unevenly or mirrored: apply its scale (Object > Apply > Scale) "
                "first"
            )

    def by_frame(self, action: bpy.types.Action | None = None) -> Generator[float, None, Bake]:
        """World matrices of the patches while the armature plays an action, its active one by default.

        Without any, whatever moves the body between the scene's first and last frame is baked. The f-curves
        are read wherever they alone decide where the patches are.

        It pauses, on the general path after each frame, and yields the share done. Between the pauses the
        scene is on another frame; at the end, or when the generator is closed early, it is as it was.
        """
        action = action or active_action(self.armature)
        curves = {} if action is None else actions.bone_curves(self.armature, action)
        motion, not_told = None, "no bone moves"
        if curves:
            try:
                motion, not_told = actions.read_action(self.armature, action), ""
            except actions.InexpressibleActionError as error:
                not_told = str(error)
        reason = why_not_fast(self.mesh, action) or not_told
        if motion is not None and not reason:
            stood = placed(motion, self.armature)
            pose = partial(patch_matrices, self._body, self.patches.triangles, stood)
            reason = "the armature's f-curves alone move the body"
            return Bake(pose, stood.n_frames, motion.rate, "fast", reason, motion, stood.pelvis)
        scene = bpy.context.scene
        frames = np.arange(scene.frame_start, scene.frame_end + 1, dtype=np.float64)
        rate = actions.scene_rate()
        if curves:
            frames, rate = actions.frames_of(action, curves)
        with at_rate(actions.key_rate(action)), playing(self.armature, action), without_empties(self.mesh):
            vertices = EvaluatedVertices(self.mesh, self.patches.triangles)
            corners = np.empty((len(frames), *self.patches.triangles.shape, 3))
            with closing(each_frame(frames)) as numbers:
                for number in numbers:
                    corners[number] = vertices.positions()
                    yield (number + 1) / len(frames)
        return Bake(partial(triangle_frames, corners), len(frames), rate, "general", reason, motion)

    @cached_property
    def _body(self) -> Body:
        return body_of(self.mesh)


def _is_even(item: bpy.types.Object) -> bool:
    """Whether an object is scaled evenly along its axes and not mirrored."""
    axes = matrix(item.matrix_world)[:3, :3]
    scales = np.linalg.norm(axes, axis=0)
    return np.ptp(scales) <= 1e-4 * scales.max() and np.linalg.det(axes) > 0


def placed(motion: Motion, armature: bpy.types.Object) -> Motion:
    """A motion in the armature's space, moved to the armature's place in the world."""
    place = matrix(armature.matrix_world) @ np.linalg.inv(body_space(armature))
    rotations = motion.rotations.copy()
    rotations[:, 0] = place[:3, :3] @ rotations[:, 0]
    return replace(motion, rotations=rotations, pelvis=motion.pelvis @ place[:3, :3].T + place[:3, 3])


def why_not_fast(mesh: bpy.types.Object, action: bpy.types.Action | None) -> str:
    """The first thing besides the action's bone curves that moves the body, or ""."""
    return next(_modifiers(mesh, armature_of(mesh)), "") or moved_besides_bones(mesh, action)


def moved_besides_bones(mesh: bpy.types.Object, action: bpy.types.Action | None) -> str:
    """Like `why_not_fast`, but ignores the body's modifiers."""
    return next(_besides(mesh, action), "")


def _besides(mesh: bpy.types.Object, action: bpy.types.Action | None) -> Iterator[str]:
    armature = armature_of(mesh)
    keys = mesh.data.shape_keys
    if keys is not None:
        used = any(block.value != 0 and not block.mute for block in keys.key_blocks[1:])
        if used or keys.animation_data is not None:
            yield f"'{mesh.name}' has shape keys in use"
    for item in dict.fromkeys((*with_parents(mesh), *with_parents(armature))):
        yield from _object_motion(item, armature)
    yield from _armature_state(armature)
    yield from _bones(mesh, armature)
    if action is None or not actions.bone_curves(armature, action):
        yield f"'{armature.name}' has no action that moves its bones"
    elif any(curve.data_path in actions.OBJECT_CHANNELS for curve in actions.slot_curves(armature, action)):
        yield f"the action '{action.name}' moves '{armature.name}' as a whole"


def _modifiers(mesh: bpy.types.Object, armature: bpy.types.Object) -> Iterator[str]:
    shown = [modifier for modifier in mesh.modifiers if modifier.show_viewport]
    deforming = [item for item in shown if item.type == "ARMATURE" and item.object == armature]
    for modifier in shown:
        if modifier.type != "COLLISION" and modifier not in deforming:
            yield f"'{mesh.name}' has the modifier '{modifier.name}'"
    if len(deforming) != 1:
        yield f"'{mesh.name}' has {len(deforming)} active armature modifiers"
    for modifier in deforming:
        if modifier.use_deform_preserve_volume or modifier.use_bone_envelopes or modifier.vertex_group:
            yield f"the armature modifier of '{mesh.name}' does more than linear blend skinning"
        if not modifier.use_vertex_groups:
            yield f"the armature modifier of '{mesh.name}' ignores its vertex groups"
    if mesh.parent == armature and mesh.parent_type != "OBJECT":
        yield f"'{mesh.name}' is parented to bones"


def _object_motion(item: bpy.types.Object, armature: bpy.types.Object) -> Iterator[str]:
    if any(not constraint.mute and constraint.influence > 0 for constraint in item.constraints):
        yield f"'{item.name}' has constraints"
    if item.data is not None and item.data.animation_data is not None:
        yield f"the data of '{item.name}' is animated"
    animation = item.animation_data
    if animation is None:
        return
    if len(animation.drivers):
        yield f"'{item.name}' has drivers"
    if animation.use_nla and any(not track.mute and len(track.strips) for track in animation.nla_tracks):
        yield f"'{item.name}' plays NLA strips"
    if item != armature and animation.action is not None:
        yield f"'{item.name}' is animated"


def _armature_state(armature: bpy.types.Object) -> Iterator[str]:
    if armature.data.pose_position == "REST":
        yield f"'{armature.name}' shows its rest pose"
    animation = armature.animation_data
    if animation is not None and (
        animation.action_influence != 1 or animation.action_blend_type != "REPLACE"
    ):
        yield f"'{armature.name}' plays its action only in part"
    if not _is_even(armature):
        yield f"'{armature.name}' is scaled unevenly or mirrored"


def _bones(mesh: bpy.types.Object, armature: bpy.types.Object) -> Iterator[str]:
    bones = armature.data.bones
    for joint, name in enumerate(JOINT_NAMES):
        bone = bones[name]
        parent = JOINT_NAMES[PARENTS[joint]] if PARENTS[joint] >= 0 else None
        if (bone.parent.name if bone.parent else None) != parent:
            yield f"the bone '{name}' has another parent than in SMPL"
        if not bone.use_deform or not bone.use_inherit_rotation or bone.bbone_segments > 1:
            yield f"the bone '{name}' bends, does not deform or does not inherit rotation"
        if any(not c.mute and c.influence > 0 for c in armature.pose.bones[name].constraints):
            yield f"the bone '{name}' has constraints"
    others = {bone.name for bone in bones if bone.use_deform} - set(JOINT_NAMES)
    if others & {group.name for group in mesh.vertex_groups}:
        yield f"'{mesh.name}' also follows other bones than the 24"
