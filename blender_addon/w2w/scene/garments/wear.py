# SPDX-License-Identifier: GPL-3.0-or-later
"""A body that puts on garments, moves once and goes again, as a run needs it for each of its clips."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import bpy

from ...core.body.body import Body
from ...core.body.skeleton import JOINT_NAMES
from ...core.garments.cover import Cover
from ...core.garments.cut import split_name
from ...core.garments.on_cloth import ClothSensors
from ...core.motion.motion import Motion
from ...core.patches.patches import PatchSet
from ..base.body import BodyObjects, add_body
from ..base.steps import without_pauses
from ..motion.takes import existing_data, new_data
from .bake import check_garment, cover_of
from .cloth import dress, lie_on
from .follow import follow


def fitted(garment: str, body: Body, patches: PatchSet) -> Cover:
    """The patches of a body that a garment covers; a `ValueError` where it cannot be worn or covers none."""
    with _dressed(body, (garment,)) as (objects, (item,)):
        check_garment(item, objects.mesh)
        return cover_of(item, objects.mesh, patches)


def followed(body: Body, patches: PatchSet, covers: Mapping[str, Cover], motion: Motion) -> ClothSensors:
    """Where the sensors on garments are while a body moves, from what each garment covers, by its name.

    Raises `ValueError` if a garment cannot be worn, or its cloth flies apart.
    """
    with _dressed(body, tuple(covers)) as (objects, garments):
        return without_pauses(follow(objects.mesh, garments, tuple(covers.values()), motion, patches))


@contextmanager
def _dressed(body: Body, garments: tuple[str, ...]) -> Iterator[tuple[BodyObjects, list[bpy.types.Object]]]:
    """A body and its garments in the open scene, removed again at the end."""
    before = existing_data()
    libraries = set(bpy.data.libraries)
    try:
        objects = add_body(body)
        items = []
        for garment in garments:
            file, name = split_name(garment)
            items.append(put_on(file, name, objects) if file else dress(objects.mesh, name))
        yield objects, items
    finally:
        bpy.data.batch_remove(new_data(before))
        bpy.data.batch_remove([item for item in bpy.data.libraries if item not in libraries])


def put_on(path: str | Path, name: str, objects: BodyObjects) -> bpy.types.Object:
    """Append a garment from a .blend file and let it follow this body instead of the one in its file.

    Its dependencies come along: lattices, other meshes. An armature with the bones of a body becomes this
    body's; so does the mesh of the same body. Raises `ValueError` if the file cannot be read, does not hold
    the garment, or it follows no body there.
    """
    before = existing_data()
    garment = _append(Path(path), name)
    came = [item for item in new_data(before) if isinstance(item, bpy.types.Object)]
    n_vertices = len(objects.mesh.data.vertices)
    bodies = [
        item
        for item in came
        if item is not garment and item.type == "MESH" and len(item.data.vertices) == n_vertices
    ]
    rigs = [
        item for item in came if item.type == "ARMATURE" and set(JOINT_NAMES) <= set(item.data.bones.keys())
    ]
    if not rigs:
        raise ValueError(
            f"'{name}' in {path} follows no body: in that file let it follow a body that Add Body made, by "
            "its armature or its mesh"
        )
    for theirs, ours in ((bodies, objects.mesh), (rigs, objects.armature)):
        for item in theirs:
            item.user_remap(ours)
    home = objects.mesh.users_collection[0]
    for item in came:
        if item not in bodies and item not in rigs:
            home.objects.link(item)
    if any(modifier.type == "CLOTH" for modifier in garment.modifiers):
        lie_on(objects.mesh)
    bpy.context.view_layer.update()
    return garment


def _append(path: Path, name: str) -> bpy.types.Object:
    try:
        with bpy.data.libraries.load(str(path), link=False) as (held, wanted):
            names = list(held.objects)
            wanted.objects = [name] if name in names else []
    except OSError as error:
        raise ValueError(f"{path} cannot be read as a .blend file: {error}") from error
    if name not in names:
        known = ", ".join(sorted(names)[:12]) or "none"
        raise ValueError(f"{path} holds no object '{name}'; its objects are: {known}")
    found = wanted.objects[0]
    if found is None:
        raise ValueError(f"'{name}' cannot be read from {path}: the file is damaged")
    return found
