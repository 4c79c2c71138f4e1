# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment of one's own out of a .blend file, put on a body here as it was on the body there."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...core.body.skeleton import JOINT_NAMES
from ..body import BodyObjects
from ..takes import existing_data, new_data
from .cloth import lie_on


def put_on(path: str | Path, name: str, objects: BodyObjects) -> bpy.types.Object:
    """Append a garment and let it follow a body instead of the one that it follows in its file.

    What it hangs on comes along: lattices, other meshes. An armature with the bones of a body
    becomes this body's; so does the mesh of the same body.

    Parameters
    ----------
    path : str or Path
        A .blend file.
    name : str
        The garment's object.
    objects : BodyObjects
        Who wears it.

    Raises
    ------
    ValueError
        If the file cannot be read, does not hold it, or it follows no body there.
    """
    before = existing_data()
    garment = _append(Path(path), name)
    came = [item for item in new_data(before) if isinstance(item, bpy.types.Object)]
    bodies = [item for item in came if item is not garment and _same_mesh(item, objects.mesh)]
    rigs = [item for item in came if _is_rig(item)]
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


def _is_rig(item: bpy.types.Object) -> bool:
    return item.type == "ARMATURE" and set(JOINT_NAMES) <= set(item.data.bones.keys())


def _same_mesh(item: bpy.types.Object, mesh: bpy.types.Object) -> bool:
    return item.type == "MESH" and len(item.data.vertices) == len(mesh.data.vertices)


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
