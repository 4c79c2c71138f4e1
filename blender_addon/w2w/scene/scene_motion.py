# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of a take in the scene: from its curves, or as Blender poses the rig where more moves it."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from typing import NamedTuple

import bpy
import numpy as np

from ..core.motion.source import NOT_FINITE, SourceMotion, UnusableMotion, refuse_pose, refuse_too_long
from .actions import scene_rate, slot_curves
from .body import matrix
from .fcurves import NotFiniteError
from .playback import each_frame
from .scene_takes import SceneTake
from .takes import read_take, skeleton_of

CHANNELS = ("location", "rotation_quaternion", "rotation_axis_angle", "rotation_euler", "scale")


class AtRest(NamedTuple):
    """The channels of a bone in its rest pose."""

    rotation_mode: str
    location: tuple[float, ...] = (0.0, 0.0, 0.0)
    rotation_quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    rotation_axis_angle: tuple[float, ...] = (0.0, 0.0, 1.0, 0.0)
    rotation_euler: tuple[float, ...] = (0.0, 0.0, 0.0)
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)


def read_scene_take(found: SceneTake) -> Generator[float, None, SourceMotion]:
    """Read a take of the scene; bones without a curve in it are at rest.

    Where nothing but curves moves the bones they are read at once, and the scene stays as it is. Else
    the armature plays the take frame by frame, with a pause after each; at the end, or when the
    generator is closed early, the scene is as it was.

    Yields
    ------
    float
        Share of the frames done.

    Raises
    ------
    UnusableMotion
        If it does not move, is too long, or cannot be played now.
    """
    armature = found.take.armature
    refuse_too_long(len(found.frames), len(armature.data.bones))
    if posed_by(armature):
        motion = yield from _as_played(found)
    else:
        bones = [armature.pose.bones[name] for name in skeleton_of(armature)[0][1:]]
        try:
            motion = read_take(found.take, found.frames, [AtRest(bone.rotation_mode) for bone in bones])
        except NotFiniteError as error:
            raise UnusableMotion(NOT_FINITE) from error
    refuse_pose(motion)
    return motion


def posed_by(armature: bpy.types.Object) -> str:
    """What besides the curves of its actions moves the bones of an armature; empty where nothing does."""
    return next(_movers(armature), "")


def _movers(armature: bpy.types.Object) -> Iterator[str]:
    for bone in armature.pose.bones:
        if any(not constraint.mute for constraint in bone.constraints):
            yield f"constraints of the bone '{bone.name}'"
        rest = bone.bone
        if rest.parent is not None and not (rest.use_inherit_rotation and rest.use_local_location):
            yield f"the bone '{bone.name}', which does not inherit its parent's rotation"
    for data in (armature.animation_data, armature.data.animation_data):
        if data is not None and len(data.drivers):
            yield "drivers"
    item = armature
    while item is not None:
        if any(not constraint.mute for constraint in item.constraints):
            yield f"constraints of '{item.name}'"
        if item != armature and item.animation_data is not None:
            yield f"the animation of '{item.name}'"
        item = item.parent


def _as_played(found: SceneTake) -> Generator[float, None, SourceMotion]:
    armature = found.take.armature
    names, parents, rest = skeleton_of(armature)
    bones = [armature.pose.bones[name] for name in names[1:]]
    world = np.empty((len(found.frames), 4, 4))
    local = np.empty((len(found.frames), len(bones), 4, 4))
    with _playing_alone(found), closing(each_frame(found.frames)) as numbers:
        for number in numbers:
            world[number] = matrix(armature.matrix_world)
            for index, bone in enumerate(bones):
                local[number, index] = bone.matrix
            yield (number + 1) / len(found.frames)
    matrices = np.concatenate([world[:, None], world[:, None] @ local], axis=1)
    return SourceMotion(
        names,
        parents,
        world[0] @ rest,
        matrices,
        scene_rate(),
        found.take.action.name,
        first_bone=1,
    )


@contextmanager
def _playing_alone(found: SceneTake) -> Iterator[None]:
    """Let an armature play one action and nothing else, from its rest pose; then put all back."""
    armature = found.take.armature
    data = armature.animation_data or armature.animation_data_create()
    if data.use_tweak_mode:
        raise UnusableMotion("an NLA strip of its armature is being edited: leave tweak mode (Tab) first")
    if bpy.context.view_layer.objects.get(armature.name) != armature:
        raise UnusableMotion(f"'{armature.name}' is in no visible collection: Blender does not pose it there")
    played = {name: getattr(data, name) for name in ("use_nla", "action_influence", "action_blend_type")}
    action, slot = data.action, getattr(data, "action_slot", None)
    shown = armature.hide_viewport, armature.hide_get(), armature.data.pose_position
    values = _values(found)
    pose = [[tuple(getattr(bone, name)) for name in CHANNELS] for bone in armature.pose.bones]
    try:
        armature.hide_viewport, armature.data.pose_position = False, "POSE"
        armature.hide_set(False)
        data.use_nla, data.action_influence, data.action_blend_type = False, 1.0, "REPLACE"
        data.action = found.take.action
        if hasattr(data, "action_slot"):
            data.action_slot = found.slot or data.action_slot or next(iter(found.take.action.slots), None)
        for bone in armature.pose.bones:
            _put(bone, AtRest(bone.rotation_mode)[1:])
        yield
    finally:
        data.action = action
        if slot is not None:
            data.action_slot = slot
        for name, value in played.items():
            setattr(data, name, value)
        for bone, channels in zip(armature.pose.bones, pose, strict=True):
            _put(bone, channels)
        for owner, name, value in values:
            owner[name] = value
        armature.data.pose_position = shown[2]
        armature.hide_set(shown[1])
        armature.hide_viewport = shown[0]


def _put(bone: bpy.types.PoseBone, channels: Sequence[Sequence[float]]) -> None:
    for name, value in zip(CHANNELS, channels, strict=True):
        setattr(bone, name, value)


def _values(found: SceneTake) -> list[tuple[bpy.types.PoseBone, str, object]]:
    """Custom properties of bones that a take animates, such as switches between IK and FK, as they are."""
    armature, values = found.take.armature, {}
    for curve in slot_curves(armature, found.take.action, found.slot):
        owner_path, mark, name = curve.data_path.rpartition('["')
        if mark and name.endswith('"]') and owner_path.endswith('"]'):
            owner = armature.path_resolve(owner_path)
            values[curve.data_path] = (owner, name[:-2], owner[name[:-2]])
    return list(values.values())
