# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's own armature next to the body, for comparison."""

from pathlib import Path

from mathutils import Matrix

from ...core.keypoints.facts import PoseFacts
from ...core.keypoints.pose_files import NO_FACTS
from ...core.motion.sight import TO_Z
from ...core.motion.source import motion_amount
from ...core.readers.bvh import BVH_SUFFIX, read_bvh
from ..base.actions import FIRST_FRAME, KEYED_AT, key_rate, scene_rate
from ..base.body import armature_of, matrix, same_selection
from ..base.module import bpy
from ..base.playback import same_timing
from .takes import find_takes, import_file, read_take, written_up

SOURCE = "w2w source"
"""Custom property of a collection that holds a clip's own armature: the clip's name."""

ASIDE = 1.2
"""Metres from the body to the armature next to it."""


def source_collections(name: str = "") -> list[bpy.types.Collection]:
    """Collections that hold the armature of a clip, or of any."""
    return [item for item in bpy.data.collections if SOURCE in item and (not name or item[SOURCE] == name)]


def remove_source(name: str = "") -> None:
    """Remove the armature of a clip that stands next to the body, or of all clips."""
    for collection in source_collections(name):
        data = [item.data for item in collection.objects if item.data is not None]
        actions = [take for take in bpy.data.actions if take.get(SOURCE) == collection[SOURCE]]
        bpy.data.batch_remove([*collection.objects, *data, *actions, collection])


def show_source(
    mesh: bpy.types.Object, name: str, path: Path, scale: float, pose: PoseFacts = NO_FACTS
) -> None:
    """Import a clip's FBX or BVH file next to the body, turned as its motion was; selection and timing stay.

    `scale` is that of the body to the file; the rate and the axis that is up in `pose` go before the file's.
    A file that Blender cannot import raises an `UnusableMotion`.
    """
    objects, actions = set(bpy.data.objects), set(bpy.data.actions)
    with same_selection(), same_timing():
        import_file(path, keys_as_frames=pose.rate is not None)
        rate = pose.rate or scene_rate()
    new = [item for item in bpy.data.objects if item not in objects]
    brought = set(bpy.data.actions) - actions
    for action in brought:
        action[SOURCE], action[KEYED_AT] = name, rate
    armature = next(item for item in new if item.type == "ARMATURE")
    armature.show_in_front = True
    take = max(find_takes(armature, brought), key=lambda take: motion_amount(read_take(take)))
    stand = _stand_beside(mesh, new, name, scale)
    is_bvh = path.suffix.lower() == BVH_SUFFIX  # which does not say its axis: the reader finds it
    if up := pose.up or (read_bvh(path, pose.rate).up if is_bvh else None):
        shown = TO_Z[up] @ TO_Z["y" if is_bvh else written_up(path)].T
        stand.rotation_euler = Matrix(shown.tolist()).to_euler()
    _play_at_own_speed(armature, take.action, take.frame_range[0])


def _stand_beside(
    mesh: bpy.types.Object, new: list[bpy.types.Object], name: str, scale: float
) -> bpy.types.Object:
    """Put objects into a collection of the clip, on the returned empty that scales them."""
    collection = bpy.data.collections.new(f"Source: {name}")
    collection[SOURCE] = name
    bpy.context.scene.collection.children.link(collection)
    stand = bpy.data.objects.new(f"Source: {name}", None)
    stand.empty_display_size = 0.2
    stand.location = matrix(armature_of(mesh).matrix_world)[:3, 3] + (ASIDE, 0, 0)
    stand.scale = (scale,) * 3
    collection.objects.link(stand)
    for item in new:
        for other in list(item.users_collection):
            other.objects.unlink(item)
        collection.objects.link(item)
        if item.parent is None:
            item.parent = stand
    return stand


def keep_pace_beside(name: str) -> None:
    """Let a clip's own armature play at its speed at the scene's present frame rate."""
    for collection in source_collections(name):
        for item in collection.objects:
            for track in item.animation_data.nla_tracks if item.animation_data else ():
                for strip in track.strips:
                    strip.scale = scene_rate() / key_rate(strip.action)


def _play_at_own_speed(armature: bpy.types.Object, action: bpy.types.Action, first: int) -> None:
    """Start with the body's clip and keep its speed at the scene's frame rate, by an NLA strip."""
    data = armature.animation_data
    slot = getattr(data, "action_slot", None) if data.action == action else None
    data.action = None
    strip = data.nla_tracks.new().strips.new(action.name, int(FIRST_FRAME), action)
    if hasattr(strip, "action_slot") and slot is not None:
        strip.action_slot = slot
    strip.action_frame_start = first
    strip.scale = scene_rate() / key_rate(action)
    strip.frame_start = FIRST_FRAME
