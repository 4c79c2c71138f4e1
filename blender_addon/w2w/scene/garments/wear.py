# SPDX-License-Identifier: GPL-3.0-or-later
"""A body that puts on garments, moves once, and goes again: what a run does with each of its clips."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import bpy

from ...core.body.body import Body
from ...core.garments.cover import Cover
from ...core.garments.cut import KINDS, split_name
from ...core.garments.on_cloth import Worn
from ...core.motion.motion import Motion
from ...core.patches.patches import PatchSet
from ..body import BodyObjects, add_body
from ..pauses import without_pauses
from ..takes import existing_data, new_data
from .bake import check_garment, cover_of, follow
from .cloth import dress
from .files import put_on


def fitted(garment: str, body: Body, patches: PatchSet) -> Cover:
    """The patches of a body that a garment covers.

    Raises
    ------
    ValueError
        If it cannot be worn, or covers none.
    """
    with _dressed(body, (garment,)) as (objects, (item,)):
        check_garment(item, objects.mesh)
        return cover_of(item, objects.mesh, patches)


def worn_through(body: Body, patches: PatchSet, covers: Mapping[str, Cover], motion: Motion) -> Worn:
    """Where the sensors on garments were while a body moved.

    Parameters
    ----------
    body : Body
    patches : PatchSet
        Of the body.
    covers : mapping of str to Cover
        What each garment covers, by its name.
    motion : Motion

    Raises
    ------
    ValueError
        If a garment cannot be worn, or its cloth flies apart.
    """
    with _dressed(body, tuple(covers)) as (objects, garments):
        return without_pauses(follow(objects.mesh, garments, tuple(covers.values()), motion, patches))


@contextmanager
def _dressed(body: Body, garments: tuple[str, ...]) -> Iterator[tuple[BodyObjects, list[bpy.types.Object]]]:
    """A body in the open scene and what it wears, removed again at the end."""
    before = existing_data()
    libraries = set(bpy.data.libraries)
    try:
        objects = add_body(body)
        yield objects, [_put_on(garment, objects) for garment in garments]
    finally:
        bpy.data.batch_remove(new_data(before))
        bpy.data.batch_remove([item for item in bpy.data.libraries if item not in libraries])


def _put_on(garment: str, objects: BodyObjects) -> bpy.types.Object:
    file, name = split_name(garment)
    if file:
        return put_on(file, name, objects)
    if name not in KINDS:
        raise ValueError(f"there is no garment called '{name}': there are {' and '.join(KINDS)}")
    return dress(objects.mesh, name)
