# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches for other programs and other scenes: empties with keyframes, and a USD file of them."""

from collections.abc import Generator, Sequence
from pathlib import Path

import bpy
from bpy.props import EnumProperty

from ...core.imu.virtual import at_patches
from ...scene.bake import PatchBaker
from ...scene.base.body import same_selection, select
from ...scene.base.patches import keyed_empties, remove_keyed
from ..jobs.jobs import Step, Steps, as_steps, on_body, part
from ..study import lists, operators, scores, state
from ..viewport.framing import fold_soon
from ..viewport.overlay import picks
from .exports import PICKED, Export

KEYED = "Keyframes"
F1 = "expected_f1"
"""Custom property of a keyed empty; names with spaces are others in USD."""


def key_steps(mesh: bpy.types.Object, chosen: Sequence[int]) -> Generator[Step, None, bpy.types.Collection]:
    """Add empties that move like some patches in the clip that plays, in a collection of their own."""
    patches, utility = state.placed_patches(mesh), state.utility_of(mesh.w2w)
    baker = PatchBaker(mesh, at_patches(patches, list(chosen)))
    bake = yield from as_steps(baker.by_frame(), "following the spots", 0.0, 0.3)
    f1 = None if utility is None else scores.expected_mean(mesh.w2w, utility)
    given = [{} if f1 is None else {F1: float(f1[patch])} for patch in chosen]
    names = [f"{patches.names[patch]} {KEYED}" for patch in chosen]
    collection = bpy.data.collections.new(f"{KEYED}: {mesh.name}")
    bpy.context.scene.collection.children.link(collection)
    try:
        keys = keyed_empties(collection, names, bake.matrices, bake.rate, given)
        yield from as_steps(keys, "setting keys", 0.3, 1.0)
    except BaseException:
        remove_keyed(collection)
        raise
    fold_soon()
    return collection


@on_body
def bake_key_steps(mesh: bpy.types.Object, chosen: Sequence[int]) -> Steps:
    """Keep the empties in the scene."""
    if not chosen:
        raise ValueError(
            "No spot is chosen yet: score them first (page Details), or click a spot on the body"
        )
    collection = yield from key_steps(mesh, chosen)
    return f"Keyed {len(chosen)} spots in '{collection.name}'"


@on_body
def usd_steps(mesh: bpy.types.Object, path: Path) -> Steps:
    """Write all patches, moving, with their F1 as an attribute."""
    chosen = range(len(state.placed_patches(mesh)))
    collection = yield from part(key_steps(mesh, chosen), 0.0, 0.9)
    try:
        with same_selection():
            select(collection.objects)
            bpy.ops.wm.usd_export(
                filepath=str(path),
                selected_objects_only=True,
                export_animation=True,
                export_custom_properties=True,
            )
    finally:
        remove_keyed(collection)
    return f"Saved {len(chosen)} moving spots: {path}"


class W2W_OT_bake_patches(operators.StartsJob, operators.OnPatches, bpy.types.Operator):
    """Copy spots as empties with a key in every frame of the clip that plays, free of the body"""

    bl_label = "Bake to Keyframes"

    which: EnumProperty(
        name="Which",
        description="The spots that are copied",
        items=(
            ("SET", "Chosen Sensors", "The sensors that are marked on the body"),
            PICKED,
            ("ALL", "All Spots", "All spots"),
        ),
    )

    def steps(self, body: bpy.types.Object) -> Steps:
        study, every = body.w2w, range(len(state.placed_patches(body)))
        chosen = {
            "SET": [row.patch for row in lists.leading(study)],
            "PICKED": [patch for patch in picks(bpy.context, body) if patch in every],
            "ALL": list(every),
        }[self.which]
        return bake_key_steps(body, chosen)


class W2W_OT_export_patches(Export, bpy.types.Operator):
    """Save all spots as they move in the clip that plays, with their F1, for other programs (USD)"""

    bl_label = "Export Spots"

    usual = "patches.usdc"
    write = staticmethod(usd_steps)
