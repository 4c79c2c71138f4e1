# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's own armature beside the body, for comparison."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..core.motion.source import UnusableMotion
from ..scene.actions import FIRST_FRAME, scene_rate
from ..scene.body import armature_of, matrix
from ..scene.takes import find_takes, import_file, motion_amount, read_take
from . import jobs
from .state import current_body

SOURCE = "w2w source"
"""Custom property of a collection that holds a clip's own armature: the clip's name."""

ASIDE = 1.2
"""Metres from the body to the armature beside it."""


def source_collections(name: str = "") -> list[bpy.types.Collection]:
    """Collections that hold the armature of a clip, or of any."""
    return [item for item in bpy.data.collections if SOURCE in item and (not name or item[SOURCE] == name)]


def remove_source(name: str = "") -> None:
    """Remove the armature of a clip that stands beside the body, or of all clips."""
    for collection in source_collections(name):
        data = [item.data for item in collection.objects if item.data is not None]
        actions = [take for take in bpy.data.actions if take.get(SOURCE) == collection[SOURCE]]
        bpy.data.batch_remove([*collection.objects, *data, *actions, collection])


class W2W_OT_show_source(bpy.types.Operator):
    """Show the active clip's own armature beside the body, or take it away again"""

    bl_idname = "w2w.show_source"
    bl_label = "Show Source Beside"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The active clip must come from a file with an armature."""
        mesh = current_body(context)
        cls.poll_message_set("The active clip has no armature of its own")
        if mesh is None or context.mode != "OBJECT" or jobs.running is not None or not len(mesh.w2w.clips):
            return False
        clip = mesh.w2w.clips[mesh.w2w.clip_index]
        return clip.action is not None and Path(clip.file).suffix.lower() in (".fbx", ".bvh")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Import it afresh, into a collection of its own."""
        mesh = current_body(context)
        clip = mesh.w2w.clips[mesh.w2w.clip_index]
        if source_collections(clip.name):
            remove_source(clip.name)
            return {"FINISHED"}
        remove_source()
        try:
            _import_beside(context, mesh, clip)
        except UnusableMotion as error:
            return jobs.show_error(self, f"{clip.name}: {error}")
        bpy.ops.w2w.preview_clip(index=mesh.w2w.clip_index)
        return {"FINISHED"}


def _import_beside(context: bpy.types.Context, mesh: bpy.types.Object, clip: bpy.types.PropertyGroup) -> None:
    """Import a clip's file; scaled to the body by an empty, so that the armature itself stays as it is."""
    name, path, scale = clip.name, Path(clip.file), clip.scale
    scene, active, chosen = context.scene, context.view_layer.objects.active, list(context.selected_objects)
    objects, actions = set(bpy.data.objects), set(bpy.data.actions)
    settings = (scene.render.fps, scene.render.fps_base, scene.frame_start, scene.frame_end)
    try:
        import_file(path)
        rate = scene_rate()
    finally:
        scene.render.fps, scene.render.fps_base, scene.frame_start, scene.frame_end = settings
    new = [item for item in bpy.data.objects if item not in objects]
    armature = next(item for item in new if item.type == "ARMATURE")
    takes = find_takes(armature, set(bpy.data.actions) - actions)
    take = max(takes, key=lambda take: motion_amount(read_take(take)))
    collection = bpy.data.collections.new(f"Source: {name}")
    collection[SOURCE] = name
    for action in set(bpy.data.actions) - actions:
        action[SOURCE] = name
    scene.collection.children.link(collection)
    stand = bpy.data.objects.new(f"Source: {name}", None)
    stand.empty_display_size = 0.2
    stand.location = matrix(armature_of(mesh).matrix_world)[:3, 3] + (ASIDE, 0, 0)
    stand.scale = (scale,) * 3
    for item in (stand, *new):
        for other in list(item.users_collection):
            other.objects.unlink(item)
        collection.objects.link(item)
        if item is not stand and item.parent is None:
            item.parent = stand
    armature.show_in_front = True
    _play_at_own_speed(armature, take.action, take.frame_range[0], rate)
    for item in context.selected_objects:
        item.select_set(False)
    for item in chosen:
        item.select_set(True)
    context.view_layer.objects.active = active


def _play_at_own_speed(armature: bpy.types.Object, action: bpy.types.Action, first: int, rate: float) -> None:
    """Start with the body's clip and keep its speed at the scene's frame rate, by an NLA strip."""
    data = armature.animation_data
    slot = getattr(data, "action_slot", None) if data.action == action else None
    data.action = None
    strip = data.nla_tracks.new().strips.new(action.name, int(FIRST_FRAME), action)
    if hasattr(strip, "action_slot") and slot is not None:
        strip.action_slot = slot
    strip.action_frame_start = first
    strip.scale = scene_rate() / rate
    strip.frame_start = FIRST_FRAME


CLASSES = (W2W_OT_show_source,)
