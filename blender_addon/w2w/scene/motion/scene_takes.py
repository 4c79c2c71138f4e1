# SPDX-License-Identifier: GPL-3.0-or-later
"""The motions of an armature in the scene: its actions and the parts of them that NLA strips play."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...core.motion.source import NOT_FINITE, SourceMotion, UnusableMotion, refuse_pose, refuse_too_long
from ...core.wording import restated
from ..base.actions import OBJECT_CHANNELS, RATE, bone_curves, scene_rate, slot_curves
from ..base.body import matrix, with_parents
from ..base.fcurves import BONE_PATH, NotFiniteError, slot_named_for
from ..base.module import bpy
from ..base.playback import each_frame, kept
from .source_beside import SOURCE
from .takes import Take, read_take, skeleton_of

EPSILON = 1e-4
"""Frames; strips keep theirs in single precision."""

Slot = object
"""A `bpy.types.ActionSlot`, which Blender has from 4.4 on."""


class SkippedTake(NamedTuple):
    """An action or strip that gives no clip, and why."""

    name: str
    reason: str


@dataclass(frozen=True, eq=False)
class SceneTake:
    """A motion of an armature in the scene.

    It has the name of its action, or of the strip that plays a part of that or at another speed. `frames`
    (T,) are in the action's time, one for each frame of the scene while it plays.
    """

    name: str
    take: Take
    frames: np.ndarray
    slot: Slot | None


def scene_takes(armature: bpy.types.Object) -> tuple[list[SceneTake], list[SkippedTake]]:
    """Every motion that an armature's actions and NLA strips hold; nothing is read or changed.

    In the order of their actions' names. An action that strips of the armature play is there as those strips:
    as itself where they play it whole. Left out are actions for these bones that another armature plays, and
    strips that are no motion.
    """
    strips, left_out = _strips(armature)
    takes: list[SceneTake] = []
    for action in sorted(bpy.data.actions, key=lambda action: action.name):
        own = [strip for strip in strips if strip.action == action]
        slots = (getattr(strip, "action_slot", None) for strip in own)
        slot = next((slot for slot in slots if slot is not None), _slot(armature, action))
        take = _take(armature, action, slot)
        if take is None:
            continue
        other = next((item for item in _players(action) if item != armature), None)
        if not own and other is not None and armature not in _players(action):
            left_out.append(SkippedTake(action.name, f"'{other.name}' plays it: choose that armature for it"))
            continue
        if not own:
            takes.append(SceneTake(action.name, take, _own_frames(take), slot))
            continue
        for strip in own:
            frames = _strip_frames(strip)
            same = [found for found in takes if found.take.action == action and _equal(found.frames, frames)]
            if same:
                left_out.append(SkippedTake(strip.name, f"it plays the same as '{same[0].name}'"))
            elif not len(frames):
                left_out.append(SkippedTake(strip.name, "this strip has no length"))
            else:
                name = action.name if _equal(frames, _own_frames(take)) else _part_name(strip, frames)
                takes.append(SceneTake(name, take, frames, slot))
    return takes, left_out


def stands_beside(armature: bpy.types.Object) -> bool:
    """Whether it is a clip's own armature that W2W shows next to the body."""
    return any(SOURCE in collection for collection in armature.users_collection)


def _take(armature: bpy.types.Object, action: bpy.types.Action, slot: Slot | None) -> Take | None:
    """An action on an armature; None if it is for other bones, or W2W made it."""
    if RATE in action or SOURCE in action:
        return None
    curves = slot_curves(armature, action, slot)
    by_bone = bone_curves(armature, action, slot)
    moved = {curve.data_path.partition('"]')[0] for curve in curves if curve.data_path.startswith(BONE_PATH)}
    if not by_bone or 2 * len(by_bone) < len(moved):
        return None
    whole = {(c.data_path, c.array_index): c for c in curves if c.data_path in OBJECT_CHANNELS}
    return Take(armature, action, by_bone | ({"": whole} if whole else {}))


def _slot(armature: bpy.types.Object, action: bpy.types.Action) -> Slot | None:
    """The slot of an action that is meant for an armature: the one that it plays, or of its name."""
    data = armature.animation_data
    if data is not None and data.action == action:
        return getattr(data, "action_slot", None)
    return slot_named_for(armature, action)


def _players(action: bpy.types.Action) -> list[bpy.types.Object]:
    """Armatures of the file that play an action, by a strip or directly."""
    armatures = (item for item in bpy.data.objects if item.type == "ARMATURE" and item.animation_data)
    return [
        item
        for item in armatures
        if item.animation_data.action == action
        or any(strip.action == action for strip in _all_strips(item.animation_data))
    ]


def _strips(armature: bpy.types.Object) -> tuple[list[bpy.types.NlaStrip], list[SkippedTake]]:
    """Strips of an armature that play an action; also muted ones, which hold stashed actions."""
    found, left_out = [], []
    for strip in _all_strips(armature.animation_data) if armature.animation_data else ():
        if strip.type != "CLIP" or strip.action is None:
            left_out.append(SkippedTake(strip.name, f"this strip plays no action ({strip.type.lower()})"))
        elif strip.use_animated_time:
            left_out.append(
                SkippedTake(strip.name, "this strip's time is animated: bake it to an action first")
            )
        else:
            found.append(strip)
    return found, left_out


def _all_strips(data: bpy.types.AnimData) -> Iterator[bpy.types.NlaStrip]:
    """All strips, those inside meta strips in place of these."""
    waiting = [strip for track in data.nla_tracks for strip in track.strips]
    while waiting:
        strip = waiting.pop(0)
        if strip.type == "META":
            waiting = [*strip.strips, *waiting]
        else:
            yield strip


def _own_frames(take: Take) -> np.ndarray:
    """Whole frames of an action: its manual range if it has one, else from key to key."""
    action = take.action
    ends = (action.frame_start, action.frame_end) if action.use_frame_range else take.frame_range
    return np.arange(round(ends[0]), round(ends[1]) + 1, dtype=np.float64)


def _strip_frames(strip: bpy.types.NlaStrip) -> np.ndarray:
    """Time of a strip's action in each frame of the scene while it plays, repeats among them."""
    start, end = strip.action_frame_start, strip.action_frame_end
    length = end - start
    if length < EPSILON:
        return np.empty(0)
    elapsed = np.arange(0, length * strip.scale * strip.repeat + EPSILON) / strip.scale
    times = np.mod(elapsed, length)
    times[(times < EPSILON) & (elapsed > EPSILON) & (elapsed > length * strip.repeat - EPSILON)] = length
    times = end - times if strip.use_reverse else start + times
    return np.where(np.abs(times - times.round()) < EPSILON, times.round(), times)


def _part_name(strip: bpy.types.NlaStrip, frames: np.ndarray) -> str:
    """The strip's name; if that is the action's, the frames that it plays are appended."""
    if not strip.name.startswith(strip.action.name):
        return strip.name
    return f"{strip.action.name} {frames.min():g} to {frames.max():g}"


def _equal(a: np.ndarray, b: np.ndarray) -> bool:
    return len(a) == len(b) and bool(np.allclose(a, b, atol=EPSILON))


class RestChannels(NamedTuple):
    """The channels of a bone in its rest pose."""

    rotation_mode: str
    location: tuple[float, ...] = (0.0, 0.0, 0.0)
    rotation_quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    rotation_axis_angle: tuple[float, ...] = (0.0, 0.0, 1.0, 0.0)
    rotation_euler: tuple[float, ...] = (0.0, 0.0, 0.0)
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)


CHANNELS = RestChannels._fields[1:]


def read_scene_take(found: SceneTake) -> Generator[float, None, SourceMotion]:
    """Read a take of the scene; bones without a curve in it are at rest. Yields the share of the frames done.

    Where nothing but curves moves the bones they are read at once, and the scene stays as it is. Else the
    armature plays the take frame by frame, with a pause after each; at the end, or when the generator is
    closed early, the scene is as it was. Raises `UnusableMotion` if it does not move, is too long, or cannot
    be played now.
    """
    armature = found.take.armature
    refuse_too_long(len(found.frames), len(armature.data.bones))
    if _posed_by_more(armature):
        motion = yield from _as_played(found)
    else:
        bones = [armature.pose.bones[name] for name in skeleton_of(armature)[0][1:]]
        with restated(NOT_FINITE, NotFiniteError, UnusableMotion):
            motion = read_take(found.take, found.frames, [RestChannels(bone.rotation_mode) for bone in bones])
    refuse_pose(motion)
    return motion


def _posed_by_more(armature: bpy.types.Object) -> bool:
    """Whether more than the curves of its actions moves the bones of an armature."""
    children = [bone for bone in armature.data.bones if bone.parent is not None]
    datas = [data for data in (armature.animation_data, armature.data.animation_data) if data is not None]
    constrained = (*armature.pose.bones, *with_parents(armature))
    return (
        any(not constraint.mute for item in constrained for constraint in item.constraints)
        or not all(bone.use_inherit_rotation and bone.use_local_location for bone in children)
        or any(len(data.drivers) for data in datas)
        or any(item.animation_data is not None for item in with_parents(armature) if item != armature)
    )


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
    take = found.take.action.name
    return SourceMotion(names, parents, world[0] @ rest, matrices, scene_rate(), take, first_bone=1)


@contextmanager
def _playing_alone(found: SceneTake) -> Iterator[None]:
    """Let an armature play one action and nothing else, from its rest pose; then put all back."""
    armature = found.take.armature
    data = armature.animation_data or armature.animation_data_create()
    if data.use_tweak_mode:
        raise UnusableMotion("an NLA strip of its armature is being edited: leave tweak mode (Tab) first")
    if bpy.context.view_layer.objects.get(armature.name) != armature:
        raise UnusableMotion(f"'{armature.name}' is in no visible collection: Blender does not pose it there")
    action, slot = data.action, getattr(data, "action_slot", None)
    hidden = armature.hide_get()
    played = (data, "use_nla", "action_influence", "action_blend_type")
    values = _values(found)
    pose = [[tuple(getattr(bone, name)) for name in CHANNELS] for bone in armature.pose.bones]
    with kept((armature, "hide_viewport"), (armature.data, "pose_position"), played):
        try:
            armature.hide_viewport, armature.data.pose_position = False, "POSE"
            armature.hide_set(False)
            data.use_nla, data.action_influence, data.action_blend_type = False, 1.0, "REPLACE"
            data.action = found.take.action
            if hasattr(data, "action_slot"):
                data.action_slot = found.slot or data.action_slot or next(iter(found.take.action.slots), None)
            for bone in armature.pose.bones:
                _put(bone, RestChannels(bone.rotation_mode)[1:])
            yield
        finally:
            data.action = action
            if slot is not None:
                data.action_slot = slot
            for bone, channels in zip(armature.pose.bones, pose, strict=True):
                _put(bone, channels)
            for owner, name, value in values:
                owner[name] = value
            armature.hide_set(hidden)


def _put(bone: bpy.types.PoseBone, channels: Sequence[Sequence[float]]) -> None:
    for name, value in zip(CHANNELS, channels, strict=True):
        setattr(bone, name, value)


def _values(found: SceneTake) -> list[tuple[bpy.types.PoseBone, str, object]]:
    """Present values of the bones' custom properties that a take animates, such as IK/FK switches."""
    armature, values = found.take.armature, {}
    for curve in slot_curves(armature, found.take.action, found.slot):
        owner_path, mark, name = curve.data_path.rpartition('["')
        if mark and name.endswith('"]') and owner_path.endswith('"]'):
            owner = armature.path_resolve(owner_path)
            values[curve.data_path] = (owner, name[:-2], owner[name[:-2]])
    return list(values.values())
