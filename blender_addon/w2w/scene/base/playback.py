# SPDX-License-Identifier: GPL-3.0-or-later
"""Walk through the frames of the scene for a while, and leave it as it was."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from . import actions
from .patches import PATCH


def active_action(armature: bpy.types.Object) -> bpy.types.Action | None:
    """The action that an armature plays."""
    return armature.animation_data.action if armature.animation_data else None


def each_frame(frames: np.ndarray) -> Generator[int, None, None]:
    """Put the scene on each frame in turn, and back where it was at the end."""
    scene = bpy.context.scene
    current, part = scene.frame_current, scene.frame_subframe
    try:
        for number, frame in enumerate(frames):
            whole = int(np.floor(frame))
            scene.frame_set(whole, subframe=float(frame - whole))
            yield number
    finally:
        scene.frame_set(current, subframe=part)


@contextmanager
def same_timing() -> Iterator[None]:
    """Keep the scene's frame rate and range, which importers set to a file's."""
    scene = bpy.context.scene
    settings = (scene.render.fps, scene.render.fps_base, scene.frame_start, scene.frame_end)
    try:
        yield
    finally:
        scene.render.fps, scene.render.fps_base, scene.frame_start, scene.frame_end = settings


@contextmanager
def at_rate(rate: float) -> Iterator[None]:
    """Let the scene run at so many frames per second, and as before at the end."""
    with same_timing():
        if rate != actions.scene_rate():
            actions.set_scene_rate(rate)
        yield


@contextmanager
def playing(armature: bpy.types.Object, action: bpy.types.Action | None) -> Iterator[None]:
    """Let the armature play an action, and the one it played before at the end."""
    before = active_action(armature)
    if action is None or action == before:
        yield
        return
    slot = getattr(armature.animation_data, "action_slot", None)
    actions.show_action(armature, action)
    try:
        yield
    finally:
        armature.animation_data.action = before
        if slot is not None:
            armature.animation_data.action_slot = slot


@contextmanager
def without_empties(mesh: bpy.types.Object) -> Iterator[None]:
    """Leave collections of this body's empties out of evaluation: they cost more than the body."""
    view_layer = bpy.context.view_layer
    idle = [
        layer
        for layer in _layer_collections(view_layer.layer_collection)
        if not layer.exclude and _holds_only_empties(layer.collection, mesh)
    ]
    empties = {item for layer in idle for item in layer.collection.all_objects}
    # what is left out is deselected and shown again by that
    selected = [item for item in empties if item.select_get(view_layer=view_layer)]
    hidden = [item for item in empties if item.hide_get(view_layer=view_layer)]
    active = view_layer.objects.active
    for layer in idle:
        layer.exclude = True
    try:
        yield
    finally:
        for layer in idle:
            layer.exclude = False
        for item in selected:
            item.select_set(True, view_layer=view_layer)
        for item in hidden:
            item.hide_set(True, view_layer=view_layer)
        view_layer.objects.active = active


def _layer_collections(layer: bpy.types.LayerCollection) -> Iterator[bpy.types.LayerCollection]:
    for child in layer.children:
        yield child
        yield from _layer_collections(child)


def _holds_only_empties(collection: bpy.types.Collection, mesh: bpy.types.Object) -> bool:
    items = collection.all_objects
    return len(items) > 0 and all(PATCH in item and item.parent == mesh for item in items)
