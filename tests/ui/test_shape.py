# SPDX-License-Identifier: GPL-3.0-or-later
"""The body by its sliders, and afterwards."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.body.shapes import shaped
from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of, body_of
from w2w.ui.jobs import jobs
from w2w.ui.study.state import BAKED, STALE, bake_settings, state_of

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender")


def test_shape_sliders_shape_the_body() -> None:
    bpy.ops.w2w.add_body(set_height=True, height=1.85, gender=1.0)
    assert bpy.context.scene.w2w.body.dimensions.z == pytest.approx(1.85, abs=0.01)
    with pytest.raises(RuntimeError, match="kg"):
        bpy.ops.w2w.add_body(set_height=True, height=2.05, set_weight=True, weight=35)


def test_the_body_is_reshaped_in_place(library: Path) -> None:
    body = make_study(library)
    study, clip = body.w2w, body.w2w.clips[0]
    utility, colours = study.utility_key, body.data.color_attributes.active_color.name
    empties = [item.name for item in study.patch_collection.objects]
    before = read_action(armature_of(body), clip.action)
    study.shape.gender = 0.6
    study.shape.set_height = True
    study.shape.height = 1.90
    expected = shaped(Body.bundled(), gender=0.6, height=1.90)
    found = body_of(body)
    np.testing.assert_allclose(found.vertices, expected.vertices, atol=1e-5)
    np.testing.assert_allclose(found.joints, expected.joints, atol=1e-5)
    after = read_action(armature_of(body), clip.action)
    np.testing.assert_allclose(after.rotations, before.rotations, atol=1e-5)
    taller = expected.joints[0, 2] / Body.bundled().joints[0, 2]
    np.testing.assert_allclose(after.pelvis, taller * before.pelvis, atol=1e-5)
    assert (study.utility_key, body.data.color_attributes.active_color.name) == (utility, colours)
    assert [item.name for item in study.patch_collection.objects] == empties
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {STALE}
    bpy.ops.w2w.reset_shape()
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {BAKED}
    np.testing.assert_allclose(body_of(body).vertices, Body.bundled().vertices, atol=1e-5)


@pytest.mark.slow
def test_a_shape_that_cannot_be_leaves_the_body_and_says_why() -> None:
    bpy.ops.w2w.add_body(set_height=True, height=2.05)
    body = bpy.context.scene.w2w.body
    before = body_of(body).vertices
    body.w2w.shape.set_weight = True
    body.w2w.shape.weight = 35
    assert "out of reach" in jobs.message.text
    assert jobs.message.is_error
    np.testing.assert_array_equal(body_of(body).joints[0, 2] > 1.0, True)
    body.w2w.shape.weight = 90
    assert jobs.message is None
    assert not np.allclose(body_of(body).vertices, before)


@pytest.mark.slow
def test_a_motion_fits_the_reshaped_body_as_if_it_had_been_imported_there(shared_data: Path) -> None:
    files = sorted((shared_data / "mixamo").rglob("*Walking*.fbx"))[:2]
    bpy.ops.w2w.add_body()
    first = bpy.context.scene.w2w.body
    bpy.ops.w2w.import_motions(directory=str(files[0].parent), files=[{"name": files[0].name}])
    first.w2w.shape.set_height = True
    first.w2w.shape.height = 1.95
    reshaped = read_action(armature_of(first), first.w2w.clips[0].action)
    bpy.ops.w2w.add_body(set_height=True, height=1.95)
    second = bpy.context.scene.w2w.body
    bpy.ops.w2w.import_motions(directory=str(files[0].parent), files=[{"name": files[0].name}])
    imported = read_action(armature_of(second), second.w2w.clips[0].action)
    apart = Rotation.from_matrix((reshaped.rotations.swapaxes(-1, -2) @ imported.rotations).reshape(-1, 3, 3))
    assert np.degrees(apart.magnitude().max()) < 2  # an import also turns bones to the new body's own
    np.testing.assert_allclose(reshaped.pelvis, imported.pelvis, atol=0.02)
