# SPDX-License-Identifier: GPL-3.0-or-later
"""The five steps through their operators, without a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import addon_utils
import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.body.shapes import shaped
from w2w.core.motion.library import MOTION_SUFFIXES
from w2w.core.motion.motion import Motion
from w2w.core.ranking.utility import CLASSIFIERS
from w2w.core.selection.subsets import greedy_subset
from w2w.core.study import record
from w2w.scene.actions import read_action
from w2w.scene.body import armature_of, body_of
from w2w.scene.patches import carrier_triangles, patch_empties
from w2w.ui import jobs, menus, packing, preferences, properties, signal_cache
from w2w.ui.baking import bake_steps
from w2w.ui.motion_import import import_steps, wanted_in_folder
from w2w.ui.pick_tool import patch_at
from w2w.ui.state import (
    BAKED,
    STALE,
    bake_settings,
    config_of,
    missing_for_any_rank,
    missing_for_bake,
    missing_for_rank,
    patches_of,
    state_of,
    utility_of,
)

N_PATCHES = 48

pytestmark = pytest.mark.usefixtures("blender")


ALL_STEPS = "motions patches signals utility"


def make_study(library: Path, steps: str = ALL_STEPS) -> bpy.types.Object:
    """A body taken through some steps; through all of them, it is saved the first time and opened later."""
    kept = library.with_name("finished study")
    if steps == ALL_STEPS and kept.is_dir():
        bpy.ops.wm.open_mainfile(filepath=str(kept / "study.blend"))
        shutil.copytree(kept / "cache", preferences.cache_folder(), dirs_exist_ok=True)
        return bpy.context.scene.w2w.body
    body = take_through(library, steps)
    if steps == ALL_STEPS:
        shutil.copytree(preferences.cache_folder(), kept / "cache")
        bpy.ops.wm.save_as_mainfile(filepath=str(kept / "study.blend"), copy=True)
    return body


def take_through(library: Path, steps: str) -> bpy.types.Object:
    """A body taken through some steps by their operators."""
    assert bpy.ops.w2w.add_body() == {"FINISHED"}
    body = bpy.context.scene.w2w.body
    body.w2w.patch_count = N_PATCHES
    body.w2w.patch_method = "fast"
    if "motions" in steps:
        assert bpy.ops.w2w.import_folder(directory=str(library)) == {"FINISHED"}
    if "patches" in steps:
        assert bpy.ops.w2w.place_patches() == {"FINISHED"}
    if "signals" in steps:
        assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    if "utility" in steps:
        assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    return body


def names_in_file() -> dict[str, list[str]]:
    """Every object, collection, action and mesh."""
    data = bpy.data
    return {
        kind: sorted(getattr(data, kind).keys()) for kind in ("objects", "collections", "actions", "meshes")
    }


def test_each_step_says_what_is_missing(library: Path) -> None:
    assert missing_for_bake(None) == "Add a body first (step 1)"
    assert not bpy.ops.w2w.place_patches.poll()
    body = make_study(library, "")
    assert "Import motions" in missing_for_bake(body)
    bpy.ops.w2w.import_folder(directory=str(library))
    assert "Place patches" in missing_for_bake(body)
    bpy.ops.w2w.place_patches()
    assert missing_for_bake(body) == ""
    assert "Bake" in missing_for_rank(body)
    assert not bpy.ops.w2w.rank_patches.poll()
    bpy.ops.w2w.bake_signals()
    assert missing_for_rank(body) == ""


def test_baked_signals_are_those_of_core(library: Path) -> None:
    body = make_study(library, "motions patches signals")
    clip = body.w2w.clips[4]
    motion = read_action(armature_of(body), clip.action)
    expected = record(body_of(body), patches_of(body), motion, config_of(body.w2w))
    baked = signal_cache.recording(clip.signals)
    np.testing.assert_allclose(baked.acc, expected.acc, atol=1e-4)
    np.testing.assert_allclose(baked.gyr, expected.gyr, atol=1e-4)


def test_the_joint_that_moves_decides_where_its_activity_is_seen(library: Path) -> None:
    body = make_study(library)
    utility = utility_of(body.w2w)
    assert set(utility.activities) == {"waving", "kicking", "stepping"}
    regions = np.array(patches_of(body).regions)
    waving = utility.f1[:, utility.activities.index("waving")]
    on_right_arm = np.array([region.startswith(("right upper arm", "right forearm")) for region in regions])
    assert waving[on_right_arm].min() > 0.9
    assert len(body.data.color_attributes) == 4
    assert not body.w2w.show_patches
    assert [place.patch for place in body.w2w.chosen] == list(greedy_subset(utility.f1, 0.9).order)


def test_the_target_and_the_ticks_choose_anew_at_once(library: Path) -> None:
    body = make_study(library)
    study, utility = body.w2w, utility_of(body.w2w)
    study.target = 1.0
    assert [place.patch for place in study.chosen] == list(greedy_subset(utility.f1, 1.0).order)
    study.activities[0].use = False
    expected = greedy_subset(utility.f1[:, 1:], 1.0)
    assert [place.patch for place in study.chosen] == list(expected.order)
    best = utility.f1[:, 1:].mean(axis=1).max()
    assert study.regions[0].f1 == pytest.approx(best, abs=1e-6)
    chosen = {patch_empties(study.patch_collection).index(item) for item in study.chosen_collection.objects}
    assert chosen == set(expected.order)


def test_views_show_their_heatmap(library: Path) -> None:
    body = make_study(library)
    for number, activity in enumerate(body.w2w.activities, start=1):
        body.w2w.view = f"A{number}"
        assert body.data.color_attributes.active_color.name == f"F1: {activity.name}"
    body.w2w.view = "MEAN"
    assert body.data.color_attributes.active_color.name == "Mean F1"


def test_placing_again_leaves_nothing_stale(library: Path) -> None:
    body = make_study(library)
    objects = len(bpy.data.objects)
    body.w2w.patch_seed = 1
    bpy.ops.w2w.place_patches()
    assert len(bpy.data.objects) == objects
    assert utility_of(body.w2w) is None
    assert len(body.data.color_attributes) == 0
    assert {state_of(clip, bake_settings(body.w2w)) for clip in body.w2w.clips} == {STALE}
    empties = patch_empties(body.w2w.patch_collection)
    np.testing.assert_array_equal(carrier_triangles(empties), patches_of(body).triangles)


def test_another_sensor_makes_signals_stale_and_the_old_one_brings_them_back(library: Path) -> None:
    body = make_study(library, "motions patches signals")
    study = body.w2w
    study.sensor = "watch"
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {STALE}
    study.sensor = "bmi270"
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {BAKED}


def test_two_studies_in_one_file_do_not_mix(library: Path) -> None:
    first = make_study(library)
    before = (first.w2w.utility_key, [clip.signals for clip in first.w2w.clips], len(first.w2w.chosen))
    second = make_study(library, "motions patches")
    assert second is not first
    assert len(second.w2w.activities) == 0
    bpy.ops.w2w.remove_patches()
    assert (first.w2w.utility_key, [c.signals for c in first.w2w.clips], len(first.w2w.chosen)) == before
    assert len(first.w2w.patch_collection.objects) == N_PATCHES
    assert {clip.action for clip in first.w2w.clips}.isdisjoint({clip.action for clip in second.w2w.clips})


def test_a_copied_body_does_not_claim_the_patches_of_the_first(library: Path) -> None:
    body = make_study(library, "patches")
    copy = body.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert patches_of(copy) is None
    assert patches_of(body) is not None


def test_a_saved_file_reopens_complete(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    utility, triangles = utility_of(body.w2w), patches_of(body).triangles
    chosen = [(place.patch, place.label) for place in body.w2w.chosen]
    path = str(tmp_path / "study.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    packing._unpacked.clear()
    bpy.ops.wm.open_mainfile(filepath=path)
    body = bpy.context.scene.w2w.body
    np.testing.assert_array_equal(utility_of(body.w2w).f1, utility.f1)
    np.testing.assert_array_equal(patches_of(body).triangles, triangles)
    assert [(place.patch, place.label) for place in body.w2w.chosen] == chosen
    assert all(signal_cache.has(clip.signals) for clip in body.w2w.clips)


def test_without_the_extension_heatmaps_are_plain_colour_attributes(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    body.w2w.view = "A2"
    expected = {attribute.name: pixels(attribute) for attribute in body.data.color_attributes}
    path = tmp_path / "study.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    plain = subprocess.run(
        [sys.executable, Path(__file__).with_name("read_plainly.py"), path, tmp_path / "found.npz"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert plain.returncode == 0, plain.stderr
    with np.load(tmp_path / "found.npz") as found:
        assert found["active"] == f"F1: {body.w2w.activities[1].name}"
        assert found["empties"] == N_PATCHES
        assert set(found["names"]) == set(expected)
        for name, colours in expected.items():
            np.testing.assert_array_equal(found[name], colours)


def pixels(attribute: bpy.types.Attribute) -> np.ndarray:
    """Colours of an attribute."""
    values = np.empty(4 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("color", values)
    return values


def test_ranking_bakes_again_what_the_cache_has_lost(library: Path) -> None:
    body = make_study(library)
    expected = utility_of(body.w2w).f1.copy()
    bpy.ops.w2w.clear_cache()
    signal_cache.forget()
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    np.testing.assert_array_equal(utility_of(body.w2w).f1, expected)


def test_a_cancelled_import_leaves_the_file_as_it_was(library: Path) -> None:
    body = make_study(library, "")
    before = names_in_file()
    steps = import_steps(body, wanted_in_folder(library))
    for _ in range(4):
        next(steps)
    assert len(body.w2w.clips) == 3
    steps.close()
    assert len(body.w2w.clips) == 0
    assert names_in_file() == before


def test_a_cancelled_bake_leaves_the_clips_as_they_were(library: Path) -> None:
    body = make_study(library, "motions patches")
    steps = bake_steps(body, range(len(body.w2w.clips)))
    while not body.w2w.clips[2].signals:
        next(steps)
    steps.close()
    assert not any(clip.signals or clip.baked_as for clip in body.w2w.clips)


def test_unusable_files_stay_in_the_list_and_say_why(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "")
    (tmp_path / "empty.fbx").touch()
    bpy.ops.w2w.import_motions(directory=str(tmp_path), files=[{"name": "empty.fbx"}])
    assert "empty" in body.w2w.clips[0].problem
    assert "cannot be used" in jobs.message.text
    bpy.ops.w2w.tick_clips(which="PROBLEM")
    bpy.ops.w2w.remove_clips()
    assert len(body.w2w.clips) == 0


def test_relabelling_ticked_clips_relabels_their_actions(library: Path) -> None:
    body = make_study(library, "motions")
    bpy.ops.w2w.tick_clips(which="ACTIVITY")
    bpy.ops.w2w.relabel_clips(activity="greeting")
    relabelled = [clip for clip in body.w2w.clips if clip.activity == "greeting"]
    assert len(relabelled) == 3
    assert all(clip.action["activity"] == "greeting" for clip in relabelled)
    with pytest.raises(RuntimeError, match="Type an activity"):
        bpy.ops.w2w.relabel_clips(activity="  ")


def test_an_armature_of_the_scene_gives_its_motion_and_stays_as_it_is(library: Path) -> None:
    first = make_study(library, "motions")
    source = armature_of(first)
    bpy.ops.w2w.preview_clip(index=0)
    keys = [tuple(bone.matrix_basis.row[0]) for bone in source.pose.bones]
    source.hide_set(False)
    make_study(library, "")
    bpy.context.view_layer.objects.active = source
    source.select_set(True)
    assert bpy.ops.w2w.add_armature_motion() == {"FINISHED"}
    clip = bpy.context.scene.w2w.body.w2w.clips[0]
    given = read_action(source, first.w2w.clips[0].action)
    taken = read_action(armature_of(bpy.context.scene.w2w.body), clip.action)
    n_frames = min(given.n_frames, taken.n_frames)
    assert n_frames > 60
    assert keys == [tuple(bone.matrix_basis.row[0]) for bone in source.pose.bones]


def test_actions_of_the_same_rig_in_the_scene_are_not_taken_for_the_file_s(
    library: Path, tmp_path: Path
) -> None:
    bpy.context.scene.render.fps = 30
    body = make_study(library, "motions")
    armature, clips = armature_of(body), body.w2w.clips
    export_clip(body, 4, tmp_path / "one.fbx")
    expected = read_action(armature, clips[4].action)
    bpy.ops.w2w.import_motions(directory=str(tmp_path), files=[{"name": "one.fbx"}])
    found = read_action(armature, clips[-1].action)
    np.testing.assert_allclose(turns(found), turns(expected), atol=4)


def turns(motion: Motion) -> np.ndarray:
    """Widest turn of each joint, degrees."""
    angles = Rotation.from_matrix(motion.rotations.reshape(-1, 3, 3)).magnitude()
    return np.degrees(angles.reshape(motion.n_frames, -1).max(axis=0))


def export_clip(body: bpy.types.Object, index: int, path: Path) -> None:
    """Write the body's armature with one clip as an FBX file."""
    bpy.ops.w2w.preview_clip(index=index)
    scene, armature = bpy.context.scene, armature_of(body)
    scene.frame_start, scene.frame_end = 1, scene.frame_preview_end
    armature.hide_set(False)
    bpy.ops.object.select_all(action="DESELECT")
    armature.select_set(True)
    addon_utils.enable("io_scene_fbx")
    bpy.ops.export_scene.fbx(
        filepath=str(path), use_selection=True, object_types={"ARMATURE"}, add_leaf_bones=False,
        bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
    )  # fmt: skip


def test_shape_sliders_shape_the_body() -> None:
    bpy.ops.w2w.add_body(set_height=True, height=1.85, gender=1.0)
    assert bpy.context.scene.w2w.body.dimensions.z == pytest.approx(1.85, abs=0.01)
    with pytest.raises(RuntimeError, match="kg"):
        bpy.ops.w2w.add_body(set_height=True, height=2.05, set_weight=True, weight=35)


def test_an_unfit_mesh_is_refused_with_a_reason(library: Path) -> None:
    make_study(library, "")
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(RuntimeError, match="no armature modifier"):
        bpy.ops.w2w.use_mesh()
    assert jobs.message.is_error


def test_a_click_finds_the_patch_of_the_posed_surface(library: Path) -> None:
    body = make_study(library, "motions patches")
    bpy.ops.w2w.preview_clip(index=0)
    bpy.context.scene.frame_set(20)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = body.evaluated_get(depsgraph)
    labels = patches_of(body).labels
    for face in range(0, len(evaluated.data.polygons), 997):
        vertex = evaluated.data.polygons[face].vertices[0]
        place = np.array(evaluated.matrix_world @ evaluated.data.vertices[vertex].co)
        assert patch_at(depsgraph, body, face, place) == labels[vertex]
    # with other vertices than the patches know, the nearest empty decides
    body.modifiers.new("Subdivision", "SUBSURF").levels = 1
    depsgraph.update()
    empty = patch_empties(body.w2w.patch_collection)[7]
    place = np.array(empty.evaluated_get(depsgraph).matrix_world.translation)
    assert patch_at(depsgraph, body, 0, place) == 7


def test_a_classifier_that_cannot_work_here_says_why_and_can_be_changed(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = make_study(library, "motions patches signals")

    class Unavailable:
        @staticmethod
        def unavailable() -> str:
            return "the classifier needs PyTorch"

    with monkeypatch.context() as patched:
        patched.setitem(CLASSIFIERS, body.w2w.classifier, Unavailable)
        assert missing_for_rank(body).startswith("The classifier needs PyTorch")
        assert missing_for_any_rank(body) == ""
        assert not bpy.ops.w2w.rank_patches.poll()
    assert bpy.ops.w2w.rank_patches.poll()


def test_pytorch_is_found_in_a_folder_of_one_s_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "elsewhere"
    (folder / "torch").mkdir(parents=True)
    (folder / "torch" / "__init__.py").touch()
    (folder / "torch-9.8.7.dist-info").mkdir()
    (folder / "torch-9.8.7.dist-info" / "METADATA").write_text("Name: torch\nVersion: 9.8.7\n")
    monkeypatch.setattr(sys, "path", [path for path in sys.path if not (Path(path) / "torch").exists()])
    monkeypatch.delitem(sys.modules, "torch", raising=False)
    assert preferences.torch_status()[0] is False
    assert "pip install --target" in preferences.torch_status()[1]
    chosen = SimpleNamespace(torch_folder=str(folder), use_gpu=False)
    preferences._find_torch(chosen, bpy.context)
    assert preferences.torch_status() == (True, f"PyTorch 9.8.7 in {folder / 'torch'}")
    preferences.leave_torch_folders()
    assert preferences.torch_status()[0] is False


def test_the_gpu_can_be_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(preferences.GPU_VARIABLE, raising=False)
    preferences._choose_gpu(SimpleNamespace(use_gpu=False), bpy.context)
    assert os.environ[preferences.GPU_VARIABLE] == ""
    preferences._choose_gpu(SimpleNamespace(use_gpu=True), bpy.context)
    assert preferences.GPU_VARIABLE not in os.environ


def test_presets_set_the_sensor(library: Path) -> None:
    body = make_study(library, "")
    presets = sorted((menus.PRESETS / menus.PRESET_FOLDER).glob("*.py"))
    assert len(presets) >= 3
    for preset in presets:
        bpy.ops.script.execute_preset(filepath=str(preset), menu_idname="W2W_MT_study_presets")
        assert f'study.sensor = "{body.w2w.sensor}"' in preset.read_text()
        assert config_of(body.w2w).synthesis.rate_hz == body.w2w.rate


def test_everything_has_a_tooltip() -> None:
    for name in dir(bpy.ops.w2w):
        assert getattr(bpy.ops.w2w, name).get_rna_type().description, name
    for group in (properties.W2W_PG_study, properties.W2W_PG_scene):
        for prop in group.bl_rna.properties:
            if (
                not prop.is_readonly
                and not prop.is_hidden
                and not prop.identifier.endswith(("name", "_text", "_key", "ranked_as"))
            ):
                assert prop.description or prop.type in ("COLLECTION", "POINTER"), prop.identifier


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


def test_an_evaluated_bake_is_cancelled_between_frames(library: Path) -> None:
    body = make_study(library, "motions patches")
    body.modifiers.new("Smooth", "SMOOTH")
    bpy.context.scene.frame_set(5)
    steps = bake_steps(body, [0, 1])
    told = [next(steps) for _ in range(40)]
    assert sum("evaluated by Blender" in step.text for step in told) > 30
    assert [step.fraction for step in told] == sorted(step.fraction for step in told)
    steps.close()
    assert not any(clip.signals for clip in body.w2w.clips)
    assert bpy.context.scene.frame_current == 5
    assert patch_empties(body.w2w.patch_collection)[0].name in bpy.context.view_layer.objects


def test_all_kinds_of_motion_files_can_be_chosen_and_dropped() -> None:
    offered = bpy.ops.w2w.import_motions.get_rna_type().properties["filter_glob"].default
    assert offered.split(";") == [f"*{suffix}" for suffix in MOTION_SUFFIXES]
    assert menus.W2W_FH_motions.bl_file_extensions.split(";") == list(MOTION_SUFFIXES)
