# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps as colour attributes, and the file they are saved in."""

from dataclasses import replace
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from w2w.core.colours import NEUTRAL_GREY, Scale, mannequin_colours, score_colours
from w2w.core.motion.skinning import patch_matrices
from w2w.scene.base.patches import patch_empties
from w2w.scene.files.study_file import FILES, RECORD, write_study
from w2w.scene.heatmap import (
    ON_THESE_CLIPS,
    add_heatmaps,
    heatmap_names,
    map_colours,
    remove_heatmaps,
    show_heatmap,
)

from .conftest import difference, read_empties

ACTIVITIES = ("walking", "sit to stand")


@pytest.fixture
def scores(patches):
    generator = np.random.default_rng(5)
    return generator.uniform(0.2, 0.9, (len(patches), len(ACTIVITIES)))


@pytest.fixture
def study(bundled_body, patches, scores, tmp_path):
    """As much of a finished study as its file is made from."""
    utility = SimpleNamespace(expected_f1=scores, activities=ACTIVITIES, expected_mean=scores.mean(axis=1))
    for name in FILES:
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "out" / name).touch()
    return SimpleNamespace(
        out=tmp_path / "out", body=lambda: bundled_body, patches=patches, utility=utility, clips=()
    )


def attribute_colours(mesh, name):
    values = np.empty(len(mesh.data.vertices) * 4, dtype=np.float32)
    mesh.data.color_attributes[name].data.foreach_get("color_srgb", values)
    return values.reshape(-1, 4)[:, :3]


def test_each_activity_and_the_mean_is_a_colour_attribute(body_in_scene, patches, scores):
    mesh = body_in_scene.mesh
    mean = scores.mean(axis=1)
    names = add_heatmaps(mesh, patches, scores, ACTIVITIES, mean, scale=lambda _: Scale(0.0, 1.0))
    assert names == ["Expected F1", *(f"Expected F1: {name}" for name in ACTIVITIES)] == heatmap_names(mesh)
    for name, values in zip(names[1:], scores.T, strict=True):
        expected = score_colours(patches.to_vertices(values), 0, 1)
        np.testing.assert_allclose(attribute_colours(mesh, name), expected, atol=1.1 / 255)


def test_a_heatmap_s_own_range_is_that_of_its_patches(patches, scores):
    values = scores[:, 0]
    own = Scale.of(values).colours(patches, values)
    np.testing.assert_array_equal(own, Scale(values.min(), values.max()).colours(patches, values))
    assert np.abs(own - Scale(0, 1).colours(patches, values)).max() > 0.1


def test_scores_that_hardly_differ_look_alike_unless_asked_for(body_in_scene, patches):
    values = np.linspace(0.54, 0.56, len(patches))
    mesh = body_in_scene.mesh
    (name,) = add_heatmaps(mesh, patches, np.empty((len(patches), 0)), (), values)
    np.testing.assert_allclose(
        attribute_colours(mesh, name), Scale(0.5, 0.6).colours(patches, values), atol=1.1 / 255
    )
    none = np.empty((len(patches), 0))
    add_heatmaps(mesh, patches, none, (), values, scale=lambda scores: Scale.of(scores, 0.5))
    np.testing.assert_allclose(
        attribute_colours(mesh, name), Scale(0.3, 0.8).colours(patches, values), atol=1.1 / 255
    )


def test_patches_without_a_score_are_grey_and_spoil_no_other(patches):
    values = np.full(len(patches), 0.6)
    values[[7, 20]] = np.nan
    colours = Scale(0, 1).colours(patches, values)
    grey = (colours == NEUTRAL_GREY).all(axis=1)
    np.testing.assert_array_equal(grey, np.isin(patches.labels, [7, 20]))
    np.testing.assert_allclose(
        colours[~grey], np.tile(score_colours(0.6, 0, 1), ((~grey).sum(), 1)), atol=1e-3
    )


def test_switching_shows_another_attribute_and_paints_nothing(body_in_scene, patches, scores):
    mesh = body_in_scene.mesh
    names = add_heatmaps(mesh, patches, scores, ACTIVITIES, scores.mean(axis=1))
    painted = {layer.name: layer.as_pointer() for layer in mesh.data.color_attributes}
    for name in names:
        show_heatmap(mesh, name)
        bpy.context.view_layer.update()
        assert mesh.data.color_attributes.active_color.name == name
        assert mesh.data.color_attributes[mesh.data.color_attributes.render_color_index].name == name
    assert {layer.name: layer.as_pointer() for layer in mesh.data.color_attributes} == painted


def test_painting_again_leaves_nothing_stale(body_in_scene, patches, scores):
    mesh = body_in_scene.mesh
    mesh.data.color_attributes.new("mine", "BYTE_COLOR", "POINT")
    add_heatmaps(mesh, patches, scores, ACTIVITIES, scores.mean(axis=1))
    add_heatmaps(mesh, patches, scores[:, :1], ("running",), scores[:, 0])
    assert heatmap_names(mesh) == ["Expected F1", "Expected F1: running"]
    add_heatmaps(mesh, patches, scores[:, :1], ("running",), scores[:, 0], title=ON_THESE_CLIPS)
    assert heatmap_names(mesh) == ["F1 on these clips", "F1 on these clips: running"]
    remove_heatmaps(mesh)
    assert mesh.data.color_attributes.keys() == ["mine"]


def test_long_and_alike_activities_keep_names_of_their_own(body_in_scene, patches, scores):
    long = "carrying a very heavy box up a narrow flight of stairs with the "
    activities = (long + "left hand", long + "right hand", "Überkopfarbeit", "mean")
    values = np.tile(scores[:, :1], (1, 4))
    names = add_heatmaps(body_in_scene.mesh, patches, values, activities, scores[:, 0])
    assert len(set(names)) == 5
    assert set(body_in_scene.mesh.data.color_attributes.keys()) == set(names)


def test_patches_that_do_not_fit_are_refused(body_in_scene, patches, scores):
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(ValueError, match="not of this body"):
        add_heatmaps(bpy.context.active_object, patches, scores, ACTIVITIES, scores[:, 0])
    with pytest.raises(ValueError, match="no heatmap 'F1: flying'"):
        show_heatmap(body_in_scene.mesh, "F1: flying")


def test_a_study_file_opens_complete(study, bundled_body, patches, scores, waving, tmp_path):
    path = tmp_path / "study.blend"
    slower = waving.labelled("sit to stand", "two", "chair")
    chosen = [5, 11, 2]
    write_study(path, study, [waving, slower], chosen)
    assert [file for file in tmp_path.iterdir() if file != study.out] == [path]
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    mesh, armature = bpy.data.objects["Body"], bpy.data.objects["Body Armature"]
    assert heatmap_names(mesh) == ["Expected F1", "Expected F1: walking", "Expected F1: sit to stand"]
    flat = np.full(len(patches), 0.8)
    alike = map_colours(mesh, replace(Scale.of(flat), is_alike=True), patches, flat)
    np.testing.assert_allclose(alike, mannequin_colours(bundled_body), atol=0.005)
    assert set(bpy.data.actions.keys()) == {"waving one clip", "sit to stand two chair"}
    assert armature.animation_data.action.name == "waving one clip"
    assert (bpy.context.scene.render.fps, bpy.context.scene.frame_end) == (30, waving.n_frames)
    empties = patch_empties(bpy.data.collections["Patches"])
    assert [empty["order of choice"] for empty in (empties[number] for number in chosen)] == [1, 2, 3]
    assert {*bpy.data.collections["Chosen patches"].objects} == {empties[number] for number in chosen}
    assert empties[4]["Expected F1: walking"] == pytest.approx(scores[4, 0])
    assert empties[4]["Expected F1"] == pytest.approx(scores[4].mean())
    distance, angle = difference(
        read_empties(empties, np.array([1.0, 40.0])),
        patch_matrices(bundled_body, patches.triangles, waving)[[0, 39]],
    )
    assert distance < 1e-5
    assert angle < 0.01
    assert bpy.data.texts.keys() == [RECORD]
    assert not any(item.animation_data and item.animation_data.drivers for item in bpy.data.objects)
    view = next(area for area in bpy.data.screens["Layout"].areas if area.type == "VIEW_3D").spaces.active
    assert view.shading.color_type == "VERTEX"


def test_a_study_file_that_cannot_be_finished_leaves_the_old_one(study, tmp_path):
    path = tmp_path / "study.blend"
    path.write_bytes(b"the old one")

    def interrupted():
        raise KeyboardInterrupt
        yield

    with pytest.raises(KeyboardInterrupt):
        write_study(path, study, interrupted(), [])
    assert path.read_bytes() == b"the old one"
    assert {*tmp_path.iterdir()} == {path, study.out}
