# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments in the panel: put on, baked on, taken off; what cannot be worn says why."""

import bpy
import numpy as np
import pytest

from w2w.core.garments.cut import cut
from w2w.scene.base.body import add_skinned, armature_of, body_of, rest_vertices
from w2w.ui.jobs import jobs
from w2w.ui.study.covers import baker_steps, covers_steps, wardrobe_text, worn_by
from w2w.ui.study.state import BAKED, STALE, bake_settings, config_of, patches_of, state_of

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender")


def shirt_on(body):
    """A T-shirt that is skinned and no cloth: quick to bake."""
    cloth = cut("tshirt", body_of(body)).cloth
    item = add_skinned(cloth, armature_of(body), bpy.context.scene.collection, "Shirt")
    bpy.context.view_layer.objects.active = item
    return item


def test_our_own_garment_is_put_on_and_taken_off(library):
    body = make_study(library, "")
    assert bpy.ops.w2w.add_garment(kind="tshirt") == {"FINISHED"}
    (item,) = worn_by(body.w2w)
    assert [modifier.type for modifier in item.modifiers] == ["ARMATURE", "CLOTH"]
    assert body.collision is not None
    assert bpy.ops.w2w.take_off(index=0) == {"FINISHED"}
    assert worn_by(body.w2w) == []
    assert "T-Shirt" not in bpy.data.objects
    assert [modifier.type for modifier in body.modifiers] == ["ARMATURE"]


def finished(steps):
    """Texts of the steps, and what they come to."""
    texts = []
    while True:
        try:
            texts.append(next(steps).text)
        except StopIteration as stop:
            return texts, stop.value


@pytest.mark.slow
def test_what_is_worn_is_fitted_beside_the_window(library):
    body = make_study(library, "patches")
    assert bpy.ops.w2w.add_garment(kind="tshirt") == {"FINISHED"}
    (item,) = worn_by(body.w2w)
    vertices = np.empty(3 * len(item.data.vertices), dtype=np.float32)
    item.data.vertices.foreach_get("co", vertices)
    item.data.vertices.foreach_set("co", 1.1 * vertices)
    texts, baker = finished(baker_steps(body, patches_of(body)))
    assert set(texts) == {"fitting T-Shirt"}
    np.testing.assert_allclose(rest_vertices(item).ravel(), vertices, atol=1e-6)
    ((name, own),) = finished(covers_steps(body, patches_of(body)))[1].items()
    assert name == "T-Shirt"
    np.testing.assert_array_equal(own.patches, baker.worn.covers[0].patches)


@pytest.mark.slow
def test_clips_are_baked_on_what_is_worn(library):
    body = make_study(library, "motions patches")
    study = body.w2w
    for number, clip in enumerate(study.clips):
        clip.selected = number == 0
    assert bpy.ops.w2w.bake_signals(which="TICKED") == {"FINISHED"}
    on_skin = study.clips[0].signals
    item = shirt_on(body)
    assert bpy.ops.w2w.wear_garment() == {"FINISHED"}
    assert state_of(study.clips[0], bake_settings(study)) == STALE
    assert bpy.ops.w2w.bake_signals(which="TICKED") == {"FINISHED"}
    assert state_of(study.clips[0], bake_settings(study)) == BAKED
    assert study.clips[0].signals != on_skin
    assert study.clips[0].bake_path.endswith("sensors are on Shirt")
    assert config_of(study).garments == ("Shirt",)
    ((name, own),) = finished(covers_steps(body, patches_of(body)))[1].items()
    assert name == "Shirt"
    assert 0 < len(own) < len(patches_of(body))
    assert bpy.ops.w2w.take_off(index=0) == {"FINISHED"}
    assert item.name in bpy.data.objects
    assert config_of(study).garments == ()
    assert state_of(study.clips[0], bake_settings(study)) == STALE


def test_what_cannot_be_worn_says_why(library):
    body = make_study(library, "")
    item = shirt_on(body)
    item.parent = None
    item.modifiers.clear()
    with pytest.raises(RuntimeError, match="'Shirt' does not follow the body"):
        bpy.ops.w2w.wear_garment()
    assert jobs.message.is_error
    assert wardrobe_text(body.w2w) == ""


def test_a_garment_that_is_deleted_is_worn_no_more(library):
    body = make_study(library, "")
    item = shirt_on(body)
    assert bpy.ops.w2w.wear_garment() == {"FINISHED"}
    bpy.data.objects.remove(item)
    assert worn_by(body.w2w) == []
    assert bpy.ops.w2w.take_off(index=0) == {"FINISHED"}
