# SPDX-License-Identifier: GPL-3.0-or-later
"""Which motions an armature of the scene has: its actions, and the parts of them that NLA strips play."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import bpy
import numpy as np

from .actions import BONE_PATH, OBJECT_CHANNELS, RATE, bone_curves, slot_curves
from .source_beside import SOURCE
from .takes import Take

EPSILON = 1e-4
"""Frames; strips keep theirs in single precision."""

Slot = object
"""A `bpy.types.ActionSlot`, which Blender has from 4.4 on."""


class LeftOut(NamedTuple):
    """An action or strip that gives no clip, and why."""

    name: str
    reason: str


@dataclass(frozen=True, eq=False)
class SceneTake:
    """A motion of an armature in the scene.

    Parameters
    ----------
    name : str
        Of the action; of the strip where that plays a part of it or at another speed.
    take : Take
    frames : ndarray, shape (T,)
        In the action's time: one for each frame of the scene while it plays.
    slot : ActionSlot or None
    """

    name: str
    take: Take
    frames: np.ndarray
    slot: Slot | None


def scene_takes(armature: bpy.types.Object) -> tuple[list[SceneTake], list[LeftOut]]:
    """Every motion of an armature that its actions and NLA strips hold; nothing is read or changed.

    Parameters
    ----------
    armature : Object

    Returns
    -------
    takes : list of SceneTake
        In the order of their actions' names. An action that strips of the armature play is there as
        those strips: as itself where they play it whole.
    left_out : list of LeftOut
        Actions for these bones that another armature plays, and strips that are no motion.
    """
    strips, left_out = _strips(armature)
    takes: list[SceneTake] = []
    for action in sorted(bpy.data.actions, key=lambda action: action.name):
        own = [strip for strip in strips if strip.action == action]
        slot = next((slot for slot in map(_strip_slot, own) if slot is not None), _slot(armature, action))
        take = _take(armature, action, slot)
        if take is None:
            continue
        other = next((item for item in _players(action) if item != armature), None)
        if not own and other is not None and armature not in _players(action):
            left_out.append(LeftOut(action.name, f"'{other.name}' plays it: choose that armature for it"))
            continue
        if not own:
            takes.append(SceneTake(action.name, take, _own_frames(take), slot))
            continue
        for strip in own:
            frames = _strip_frames(strip)
            same = [found for found in takes if found.take.action == action and _equal(found.frames, frames)]
            if same:
                left_out.append(LeftOut(strip.name, f"it plays the same as '{same[0].name}'"))
            elif not len(frames):
                left_out.append(LeftOut(strip.name, "this strip has no length"))
            else:
                name = action.name if _equal(frames, _own_frames(take)) else _part_name(strip, frames)
                takes.append(SceneTake(name, take, frames, slot))
    return takes, left_out


def stands_beside(armature: bpy.types.Object) -> bool:
    """Whether it is a clip's own armature that W2W shows beside the body."""
    return any(SOURCE in collection for collection in armature.users_collection)


def _take(armature: bpy.types.Object, action: bpy.types.Action, slot: Slot | None) -> Take | None:
    """An action on an armature; None where it is for other bones, or W2W made it."""
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
    named = f"OB{armature.name}"
    return next((slot for slot in getattr(action, "slots", ()) if slot.identifier == named), None)


def _strip_slot(strip: bpy.types.NlaStrip) -> Slot | None:
    return getattr(strip, "action_slot", None)


def _players(action: bpy.types.Action) -> list[bpy.types.Object]:
    """Armatures of the file that play an action, by a strip or directly."""
    armatures = (item for item in bpy.data.objects if item.type == "ARMATURE" and item.animation_data)
    return [
        item
        for item in armatures
        if item.animation_data.action == action
        or any(strip.action == action for strip in _all_strips(item.animation_data))
    ]


def _strips(armature: bpy.types.Object) -> tuple[list[bpy.types.NlaStrip], list[LeftOut]]:
    """Strips of an armature that play an action, muted ones among them: so are stashed actions kept."""
    found, left_out = [], []
    for strip in _all_strips(armature.animation_data) if armature.animation_data else ():
        if strip.type != "CLIP" or strip.action is None:
            left_out.append(LeftOut(strip.name, f"this strip plays no action ({strip.type.lower()})"))
        elif strip.use_animated_time:
            left_out.append(LeftOut(strip.name, "this strip's time is animated: bake it to an action first"))
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
    """Whole frames of an action: its manual range, where it has one, else from key to key."""
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
    """The strip's own name, or where it is the action's, the frames that it plays."""
    if not strip.name.startswith(strip.action.name):
        return strip.name
    return f"{strip.action.name} {frames.min():g} to {frames.max():g}"


def _equal(one: np.ndarray, other: np.ndarray) -> bool:
    return len(one) == len(other) and bool(np.allclose(one, other, atol=EPSILON))
