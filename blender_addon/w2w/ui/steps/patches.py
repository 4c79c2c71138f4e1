# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 3: spread patches over the body."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ...core.study import place_patches as sample
from ...scene.base.patches import place_patches, remove_patches
from ...scene.files.packing import pack
from ..jobs import jobs
from ..jobs.on_body import on_body
from ..results import own_placements, results
from ..study.operators import IsJob, OnBody
from ..study.state import config_of, current_body, keep_own_placed
from .baking import body_as_run


class W2W_OT_place_patches(IsJob, bpy.types.Operator):
    """Spread patches evenly over the body, an empty on each; replaces those that are there"""

    bl_idname = "w2w.place_patches"
    bl_label = "Place Patches"

    def steps(self, body: bpy.types.Object) -> jobs.Steps:
        return place_steps(body)


class W2W_OT_remove_patches(OnBody, bpy.types.Operator):
    """Remove the patches, and the ranking that was made with them"""

    bl_idname = "w2w.remove_patches"
    bl_label = "Remove Patches"

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        return "" if body.w2w.patch_collection is not None else "There are no patches"

    def execute(self, context: bpy.types.Context) -> set[str]:
        remove_all(current_body(context))
        return {"FINISHED"}


@on_body
def place_steps(mesh: bpy.types.Object) -> jobs.Steps:
    """Sample in a thread, then replace the empties."""
    body, study = body_as_run(mesh), mesh.w2w
    own, count = list(own_placements.listed(study).items()), study.patch_count
    config = replace(config_of(study), seed=study.patch_seed, placements=tuple(own))
    patches = yield from jobs.in_thread(
        lambda _told: sample(body, config), f"spreading {count} patches", 0.0, 0.8
    )
    yield jobs.Step(0.8, "placing empties")
    remove_all(mesh)
    study = mesh.w2w
    home = mesh.users_collection[0] if mesh.users_collection else None
    study.patch_collection = place_patches(mesh, patches, f"Patches: {mesh.name}", study.patch_size, home)
    study.patches_text, study.patches_key = pack(patches)
    keep_own_placed(study, own, count)
    results.hide_patches(study)
    text = f"Placed {len(patches)} patches in {len(set(patches.regions))} regions"
    if own:
        text += f", {len(own)} of them your own"
    return text


def remove_all(mesh: bpy.types.Object) -> None:
    """Remove the body's own empties and what was learned with them."""
    study = mesh.w2w
    results.clear(mesh)
    collection = study.patch_collection
    study.patch_collection = None
    study.patches_text = study.patches_key = study.own_placed = ""
    if collection is not None and all(item.parent is mesh for item in collection.objects):
        remove_patches(collection)
