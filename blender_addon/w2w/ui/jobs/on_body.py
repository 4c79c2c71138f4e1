# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs that work on a body: they end with a sentence where it is removed or edited meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Generator
from functools import wraps
from typing import Concatenate, ParamSpec

import bpy

from .jobs import Step, Steps

GONE = "The body was removed while this ran: nothing of it was kept"

EDITED = "The body was put into Edit Mode while this ran: leave Edit Mode and start again"

P = ParamSpec("P")


def is_there(item: bpy.types.Object) -> bool:
    """Whether an object is in a scene; one that was removed is no object any more."""
    try:
        return any(scene.objects.get(item.name) is item for scene in bpy.data.scenes)
    except ReferenceError:
        return False


def on_body(make: Callable[Concatenate[bpy.types.Object, P], Steps]) -> Callable[..., Steps]:
    """Let a job's steps look before each whether their body, the first argument, is still there."""

    @wraps(make)
    def steps(mesh: bpy.types.Object, *args: P.args, **options: P.kwargs) -> Steps:
        return _watched(mesh, make(mesh, *args, **options))

    return steps


def _watched(mesh: bpy.types.Object, steps: Steps) -> Generator[Step, None, str]:
    try:
        while is_there(mesh):
            if _is_edited(mesh):
                raise ValueError(EDITED)
            try:
                step = next(steps)
            except StopIteration as stop:
                return stop.value
            yield step
        raise ValueError(GONE)
    finally:
        try:
            steps.close()
        except ReferenceError:  # what it would put back went with the body
            if is_there(mesh):
                raise


def _is_edited(mesh: bpy.types.Object) -> bool:
    """Whether the body or its armature is in Edit Mode, in which neither shows its motion."""
    armatures = [part.object for part in mesh.modifiers if part.type == "ARMATURE" and part.object]
    return any(item.mode == "EDIT" for item in (mesh, *armatures))
