# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the f-curves of an armature alone decide where a body's surface is."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np

from ..core.body.skeleton import JOINT_NAMES, PARENTS
from .actions import bone_curves, object_curves
from .body import matrix

EVEN_SCALE = 1e-4


def why_not_fast(mesh: bpy.types.Object, armature: bpy.types.Object, action: bpy.types.Action | None) -> str:
    """What besides the action's bone curves moves the body; empty where nothing does.

    Parameters
    ----------
    mesh, armature : Object
        A body and the armature that skins it.
    action : Action or None
        What the armature plays.

    Returns
    -------
    str
        The first thing found, such as "'Body' has a Subdivision modifier".
    """
    return next(_obstacles(mesh, armature, action), "")


def moved_besides_bones(
    mesh: bpy.types.Object, armature: bpy.types.Object, action: bpy.types.Action | None
) -> str:
    """What besides the action's bone curves moves the armature or reshapes the body; empty for nothing.

    As `why_not_fast`, but modifiers of the mesh may do what they like.
    """
    return next(_besides(mesh, armature, action), "")


def _obstacles(
    mesh: bpy.types.Object, armature: bpy.types.Object, action: bpy.types.Action | None
) -> Iterator[str]:
    yield from _modifiers(mesh, armature)
    yield from _besides(mesh, armature, action)


def _besides(
    mesh: bpy.types.Object, armature: bpy.types.Object, action: bpy.types.Action | None
) -> Iterator[str]:
    yield from _shape_keys(mesh)
    for item in _with_parents(mesh, armature):
        yield from _object_motion(item, armature)
    yield from _armature_state(armature)
    yield from _bones(mesh, armature)
    if action is None or not bone_curves(armature, action):
        yield f"'{armature.name}' has no action that moves its bones"
    elif object_curves(armature, action):
        yield f"the action '{action.name}' moves '{armature.name}' as a whole"


def _modifiers(mesh: bpy.types.Object, armature: bpy.types.Object) -> Iterator[str]:
    deforming = [
        m for m in mesh.modifiers if m.type == "ARMATURE" and m.object == armature and m.show_viewport
    ]
    for modifier in mesh.modifiers:
        moves = modifier.show_viewport and modifier.type != "COLLISION"
        if moves and modifier not in deforming:
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


def _shape_keys(mesh: bpy.types.Object) -> Iterator[str]:
    keys = mesh.data.shape_keys
    if keys is None:
        return
    if keys.animation_data is not None or any(
        block.value != 0 and not block.mute for block in keys.key_blocks[1:]
    ):
        yield f"'{mesh.name}' has shape keys in use"


def _with_parents(*items: bpy.types.Object) -> list[bpy.types.Object]:
    """Objects and everything they are parented to, once each."""
    found: list[bpy.types.Object] = []
    for item in items:
        current: bpy.types.Object | None = item
        while current is not None and current not in found:
            found.append(current)
            current = current.parent
    return found


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
    axes = matrix(armature.matrix_world)[:3, :3]
    scales = np.linalg.norm(axes, axis=0)
    if np.ptp(scales) > EVEN_SCALE * scales.max() or np.linalg.det(axes) <= 0:
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
