# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches in the scene: empties that ride on the triangles of a body's mesh, or have keys of their own."""

from collections.abc import Collection, Generator, Iterator, Mapping, Sequence

import numpy as np
from mathutils import Matrix

from ...core.patches.patches import PatchSet
from .actions import FIRST_FRAME, scene_rate
from .module import bpy

PATCH = "patch"
"""Custom property of an empty: number of its patch."""

REGION = "region"
"""Custom property of an empty: body region that its patch lies in."""

EMPTY_SIZE = 0.012
"""Length of an empty's axes, metres."""

MARKED_SCALE = 1.4
"""Radius of a marked empty's sphere, in lengths of its axes."""


def place_patches(
    mesh: bpy.types.Object,
    patches: PatchSet,
    name: str = "Patches",
    size: float = EMPTY_SIZE,
    parent: bpy.types.Collection | None = None,
) -> bpy.types.Collection:
    """Put an empty on the carrier triangle of each patch, in a collection of their own.

    The empties follow the surface by Blender's own three-vertex parenting, whatever moves it, and need no
    script for that: x along the triangle's first edge, z outward, at the centroid. The mesh must have the
    vertices of the body that the patches were sampled on.
    """
    check_patches(mesh, patches)
    collection = bpy.data.collections.new(name)
    (parent or bpy.context.scene.collection).children.link(collection)
    for number, empty_name in enumerate(patches.names):
        empty = new_empty(mesh, empty_name, patches.triangles[number], "ARROWS", size)
        empty[PATCH] = number
        empty[REGION] = patches.regions[number]
        collection.objects.link(empty)
    return collection


def check_patches(mesh: bpy.types.Object, patches: PatchSet) -> None:
    """Refuse patches of another body."""
    if len(patches.labels) != len(mesh.data.vertices):
        raise ValueError(
            f"the patches are not of this body: they cover {len(patches.labels)} vertices, "
            f"but '{mesh.name}' has {len(mesh.data.vertices)}"
        )


def remove_patches(collection: bpy.types.Collection) -> None:
    """Remove a collection of empties that `place_patches` made, and all that is in it."""
    bpy.data.batch_remove([*patch_empties(collection), collection])


def lost_empties(kept: Collection[bpy.types.Object]) -> Iterator[bpy.types.Object]:
    """Empties whose body is not one of those kept; those without a parent are judged by their collection."""
    lost: dict[object, bool] = {}
    for item in bpy.data.objects:
        if PATCH not in item or item.library is not None:
            continue
        is_lost = item.parent not in kept
        if item.parent is None:  # one that people set free is parented as an OBJECT is
            is_lost = lost.setdefault(item.users_collection[:1], item.parent_type != "OBJECT")
        if is_lost:
            yield item


def mark_empties(collection: bpy.types.Collection, wanted: Sequence[bpy.types.Object], size: float) -> None:
    """Let a collection hold these empties, as spheres, and no others: those that it held are axes again.

    `size` is the length of an empty's axes, metres.
    """
    for empty in list(collection.objects):
        if empty not in wanted:
            collection.objects.unlink(empty)
            empty.empty_display_type, empty.empty_display_size = "ARROWS", size
    for empty in wanted:
        if empty.name not in collection.objects:
            collection.objects.link(empty)
        empty.empty_display_type, empty.empty_display_size = "SPHERE", MARKED_SCALE * size


def patch_empties(collection: bpy.types.Collection) -> list[bpy.types.Object]:
    """The empties of a collection in the order of their patches, whatever they are called now."""
    return sorted((item for item in collection.objects if PATCH in item), key=lambda item: item[PATCH])


def empties_by_patch(collection: bpy.types.Collection) -> dict[int, bpy.types.Object]:
    """The empty of each patch that still has one, by the patch's number; copies of an empty do not count."""
    found: dict[int, bpy.types.Object] = {}
    for item in collection.objects:
        if PATCH in item:
            found.setdefault(item[PATCH], item)
    return found


def new_empty(
    mesh: bpy.types.Object, name: str, triangle: np.ndarray, display: str, size: float
) -> bpy.types.Object:
    """An empty exactly in the frame of a triangle, in no collection yet.

    World matrix = parent's world matrix @ triangle @ matrix_parent_inverse @ matrix_basis.
    Both last ones are the identity in a new object; Blender cannot work them out from an
    assigned `matrix_world`, for it leaves the triangle out of the parent.
    """
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type, empty.empty_display_size = display, size
    empty.parent, empty.parent_type = mesh, "VERTEX_3"
    empty.parent_vertices = triangle.tolist()
    return empty


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
