# SPDX-License-Identifier: GPL-3.0-or-later
"""What covers a study's body: its garments, and bakers of the patches below them."""

import json
from collections.abc import Callable, Generator
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import bpy

from ...core.garments.cut import cut
from ...core.given import inside
from ...core.imu.cover import FITTED, Cover, cover, load_covers
from ...core.patches.patches import PatchSet
from ...core.study.config import StudyConfig
from ...scene.bake import PatchBaker
from ...scene.base.body import body_of
from ...scene.cloth.bake import GarmentBaker, around_body, check_garment, refuse_bare
from ...scene.cloth.garments import KIND, refit
from ..jobs.jobs import Step, in_thread, is_there

T = TypeVar("T")

Baker: TypeAlias = PatchBaker | GarmentBaker


def worn_by(study: bpy.types.PropertyGroup) -> list[bpy.types.Object]:
    """The garments on the body, the outer first."""
    return [row.item for row in study.covers if row.item is not None and is_there(row.item)]


def wardrobe_text(study: bpy.types.PropertyGroup) -> str:
    """What signals depend on and is quickly read of the garments, or "" without any."""
    parts = []
    for item in worn_by(study):
        modifiers = " ".join(f"{modifier.type}:{modifier.show_viewport}" for modifier in item.modifiers)
        parts.append(f"{item.name} {len(item.data.vertices)} {modifiers}")
    return "\n".join(parts)


def parameters(study: bpy.types.PropertyGroup, run: StudyConfig) -> dict[str, Any]:
    """The parameters of what is worn; without any those of the run opened."""
    return {"garments": tuple(item.name for item in worn_by(study)) or run.garments}


def baker_steps(mesh: bpy.types.Object, patches: PatchSet) -> Generator[Step, None, Baker]:
    """A baker of a study's patches, on the skin or with the garments over it, which are fitted in a thread.

    Raises `ValueError` if the body cannot be baked or a garment cannot be worn.
    """
    garments = worn_by(mesh.w2w)
    if not garments:
        return PatchBaker(mesh, patches)
    body = body_of(mesh)
    for item in garments:
        check_garment(item, mesh)
        if KIND in item:
            refit(item, mesh, (yield from _while_alive(partial(cut, item[KIND], body), item)))
    covers = []
    for item in garments:
        work = partial(cover, *around_body(item, mesh), body, patches)
        covers.append((yield from _while_alive(work, item)))
        refuse_bare(item, mesh, covers[-1])
    return GarmentBaker(mesh, patches, garments, covers)


def _while_alive(work: Callable[[], T], item: bpy.types.Object) -> Generator[Step, None, T]:
    """Do numerical work on a garment in a thread."""
    return (yield from in_thread(lambda _: work(), f"fitting {item.name}", 0.0, 0.0))


def covers_steps(mesh: bpy.types.Object, patches: PatchSet) -> Generator[Step, None, dict[str, Cover]]:
    """The cover of each garment of a study, by its name; in an opened run those of that run.

    Raises `OSError` or `ValueError` if a garment cannot be worn any more, or the run's folder does not say
    what its garments covered.
    """
    study = mesh.w2w
    if worn_by(study) and isinstance(baker := (yield from baker_steps(mesh, patches)), GarmentBaker):
        return {item.name: own for item, own in zip(baker.worn.garments, baker.worn.covers, strict=True)}
    run = json.loads(study.parameters).get("garments") if study.parameters else None
    return load_covers(inside(Path(study.results_folder), FITTED)) if run else {}
