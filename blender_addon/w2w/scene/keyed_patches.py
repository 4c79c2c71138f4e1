# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches as objects of their own: empties with a key in every frame of a clip, free of the body."""

from collections.abc import Generator, Mapping, Sequence

import numpy as np
from mathutils import Matrix

from .base.actions import FIRST_FRAME, scene_rate
from .base.module import bpy
from .base.patches import EMPTY_SIZE


def keyed_empties(
    collection: bpy.types.Collection,
    names: Sequence[str],
    matrices: np.ndarray,
    rate: float,
    scores: Sequence[Mapping[str, float]],
) -> Generator[float, None, None]:
    """Add an empty for each of K names to a collection, with these scores as custom properties.

    It follows world matrices (T, K, 4, 4) at `rate` frames per second. Yields the share done.
    """
    times = FIRST_FRAME + np.arange(len(matrices)) * (scene_rate() / rate)
    for number, (name, given) in enumerate(zip(names, scores, strict=True)):
        empty = bpy.data.objects.new(name, None)
        empty.empty_display_type, empty.empty_display_size = "ARROWS", EMPTY_SIZE
        empty.rotation_mode = "QUATERNION"
        for key, score in given.items():
            empty[key] = score
        collection.objects.link(empty)
        for time, world in zip(times, matrices[:, number], strict=True):
            place, turn, _ = Matrix(world.tolist()).decompose()
            turn.make_compatible(empty.rotation_quaternion)
            empty.location, empty.rotation_quaternion = place, turn
            for channel in ("location", "rotation_quaternion"):
                empty.keyframe_insert(channel, frame=time)
        yield (number + 1) / len(names)


def remove_keyed(collection: bpy.types.Collection) -> None:
    """Remove keyed empties, their actions and their collection."""
    keyed = [item.animation_data.action for item in collection.objects if item.animation_data]
    bpy.data.batch_remove([*filter(None, keyed), *collection.objects, collection])
