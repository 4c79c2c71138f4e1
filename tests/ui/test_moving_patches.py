# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches with keyframes lie where the body's own patches do, frame by frame; a USD file has their F1."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.scene.base.patches import empties_by_patch
from w2w.ui.study import scores, state

from .made_study import N_PATCHES, make_study, names_in_file as names

pytestmark = pytest.mark.usefixtures("blender")


def world(item: bpy.types.Object) -> np.ndarray:
    """Where an object is in the frame that is shown."""
    return np.array(item.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)


def test_keyed_empties_move_like_the_patches(library: Path) -> None:
    body = make_study(library)
    body.w2w.show_patches = True
    bpy.ops.w2w.preview_clip(index=4)
    assert bpy.ops.w2w.bake_patches(which="ALL") == {"FINISHED"}
    keyed = bpy.data.collections["Keyframes: Body"].objects
    assert len(keyed) == N_PATCHES
    own, known = empties_by_patch(body.w2w.patch_collection), state.patches_of(body).names
    f1 = scores.expected_mean(body.w2w, state.utility_of(body.w2w))
    for frame in (1, 14, 30):
        bpy.context.scene.frame_set(frame)
        for patch in range(0, N_PATCHES, 5):
            item = keyed[f"{known[patch]} Keyframes"]
            np.testing.assert_allclose(world(item), world(own[patch]), atol=1e-3)
            assert item["expected_f1"] == pytest.approx(f1[patch])


def test_the_chosen_sensor_alone_is_keyed(library: Path) -> None:
    body = make_study(library)
    bpy.ops.w2w.preview_clip(index=0)
    assert bpy.ops.w2w.bake_patches(which="SET") == {"FINISHED"}
    (item,) = bpy.data.collections["Keyframes: Body"].objects
    assert item.name == f"{body.w2w.chosen[0].label} Keyframes"
    with pytest.raises(RuntimeError, match="No spot is chosen yet"):
        bpy.ops.w2w.bake_patches(which="PICKED")


@pytest.mark.slow
def test_a_usd_file_has_every_patch_with_its_f1_and_the_scene_is_as_before(
    library: Path, tmp_path: Path
) -> None:
    make_study(library)
    bpy.ops.w2w.preview_clip(index=0)
    before = names()
    path = tmp_path / "patches.usda"
    assert bpy.ops.w2w.export_patches(filepath=str(path)) == {"FINISHED"}
    assert names() == before
    path = next(tmp_path.glob("patches.*"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.usd_import(filepath=str(path))
    brought = [item for item in bpy.data.objects if "Keyframes" in item.name]
    assert len(brought) == N_PATCHES
    assert all(0 < float(item["expected_f1"]) <= 1 for item in brought)
