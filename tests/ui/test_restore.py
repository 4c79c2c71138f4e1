# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's study.blend opens as the study that it is of: nothing is baked again."""

from __future__ import annotations

import base64
import io
import os
import shutil
from pathlib import Path
from zipfile import ZipFile

import bpy
import numpy as np
import pytest

import w2w as extension
from w2w.core.imu.recording import ImuRecording
from w2w.core.motion.skinning import patch_matrices
from w2w.core.patches.body_parts import find_patches, segment
from w2w.core.study.clip_files import STORED, features_file, signals_file
from w2w.core.study.results import StudyResults
from w2w.scene.base.body import armature_of
from w2w.scene.base.patches import patch_empties
from w2w.scene.base.playback import spot_at
from w2w.scene.files.study_file import RECORD, read_record
from w2w.scene.heatmap import MEAN, heatmap_names
from w2w.ui.jobs import jobs, preferences
from w2w.ui.panels.steps import W2W_PT_utility
from w2w.ui.results import restore
from w2w.ui.study import signal_cache
from w2w.ui.study.lists import answer_of
from w2w.ui.study.state import (
    BAKED,
    FAILED,
    bake_settings,
    config_of,
    patches_of,
    rank_settings,
    state_of,
    utility_of,
)

from ..clip_lists import skipped_clips, used_clips
from ..scene.conftest import difference

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def open_file(path: Path) -> bpy.types.Object:
    """Open a file as a double-click does; gives the body that the panel shows."""
    jobs.dismiss()
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    return bpy.context.scene.w2w.body


@pytest.fixture
def opened(finished_run: Path) -> bpy.types.Object:
    """The body of the run's study.blend, opened in place."""
    return open_file(finished_run / "study.blend")


def test_ranking_choice_and_regions_are_the_runs(
    opened: bpy.types.Object, finished_run: Path, summary: dict
) -> None:
    study, run = opened.w2w, StudyResults.load(finished_run)
    np.testing.assert_array_equal(utility_of(study).f1, run.utility.f1)
    np.testing.assert_array_equal(patches_of(opened).triangles, run.patches.triangles)
    assert [place.patch for place in study.chosen] == [summary["answer"]["patch"]]
    assert answer_of(study) == summary["answer"]
    on_no_foot = ["foot" not in segment(region) for region in run.patches.regions]  # as the run's wish says
    assert study.regions[0].f1 == pytest.approx(run.utility.expected_mean[on_no_foot].max())
    assert heatmap_names(opened) == [MEAN, *(f"{MEAN}: {name}" for name in run.utility.activities)]
    assert config_of(study) == run.config()
    assert not W2W_PT_utility.missing(None, opened)
    assert study.ranked_as == rank_settings(study)
    assert jobs.message == jobs.Message("Opened a finished run: 9 clips on 24 spots", False)


def test_clips_play_and_the_unusable_one_says_why(opened: bpy.types.Object, finished_run: Path) -> None:
    study, settings = opened.w2w, bake_settings(opened.w2w)
    used = [clip for clip in study.clips if state_of(clip, settings) == BAKED]
    assert [(clip.name, clip.activity) for clip in used] == [
        (entry["clip"], entry["activity"]) for entry in used_clips(finished_run)
    ]
    assert [clip.motion_key for clip in used] == [
        clip.motion_key for clip in StudyResults.load(finished_run).clips
    ]
    (broken,) = [clip for clip in study.clips if state_of(clip, settings) == FAILED]
    assert (broken.name, broken.problem) == ("broken.bvh", *skipped_clips(finished_run).values())
    assert bpy.ops.w2w.preview_clip(index=4) == {"FINISHED"}
    assert armature_of(opened).animation_data.action == study.clips[4].action


def test_patches_ride_on_the_triangles_of_the_run(opened: bpy.types.Object, finished_run: Path) -> None:
    run, clip = StudyResults.load(finished_run), opened.w2w.clips[4]
    bpy.ops.w2w.preview_clip(index=4)
    opened.w2w.show_patches = True
    bpy.context.scene.frame_set(21)
    empties = patch_empties(opened.w2w.patch_collection)
    matrices = np.array([np.array(empty.matrix_world) for empty in empties])
    truth = patch_matrices(run.body(), run.patches.triangles, run.motion(clip.name))[20]
    distance, angle = difference(matrices, truth)
    assert distance < 1e-5
    assert angle < 0.01


def test_patches_of_a_run_are_folded_in_the_outliner(
    finished_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folded: list[bool] = []
    monkeypatch.setattr(restore, "fold_soon", lambda: folded.append(True))
    open_file(finished_run / "study.blend")
    assert folded == [True]


def test_a_click_on_the_skin_picks_the_runs_patch(opened: bpy.types.Object, finished_run: Path) -> None:
    run = StudyResults.load(finished_run)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = opened.evaluated_get(depsgraph).data
    for face in range(0, len(mesh.polygons), 1999):
        corner = mesh.polygons[face].vertices[0]
        place = np.array(opened.matrix_world @ mesh.vertices[corner].co)
        assert spot_at(depsgraph, opened, patches_of(opened), face, place)[0] == run.patches.labels[corner]
    assert bpy.ops.w2w.select_patch(patch=7) == {"FINISHED"}
    assert opened.w2w.picked == 7


def test_signals_are_read_from_the_results_folder(opened: bpy.types.Object, finished_run: Path) -> None:
    for clip in opened.w2w.clips[:2]:
        stored = ImuRecording.load(signals_file(finished_run, clip.name))
        np.testing.assert_array_equal(signal_cache.recording(clip).acc, stored.acc)


@pytest.mark.slow
def test_ranking_again_needs_no_baking_and_gives_the_same(
    opened: bpy.types.Object,
) -> None:
    before = utility_of(opened.w2w)
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    assert jobs.message.text == "All signals are up to date"
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    again = utility_of(opened.w2w)
    np.testing.assert_array_equal(again.f1, before.f1)
    # Blender keeps vertices in single precision: distances over the skin differ by that
    np.testing.assert_allclose(again.expected_f1, before.expected_f1, atol=1e-6)
    assert not list(preferences.cache_folder().iterdir())


def test_ticks_choose_within_the_runs_constraints(opened: bpy.types.Object) -> None:
    study = opened.w2w
    study.target = 1.0
    study.activities["run"].part = "LEFT_OUT"
    patches = patches_of(opened)
    forbidden = find_patches(patches.regions, patches.names, "foot")
    assert len(forbidden)
    assert study.chosen
    assert not {place.patch for place in study.chosen} & set(forbidden.tolist())


def test_a_damaged_record_is_said_and_leaves_the_file_as_it_is(finished_run: Path, tmp_path: Path) -> None:
    extension.unregister()
    bpy.ops.wm.open_mainfile(filepath=str(finished_run / "study.blend"), use_scripts=False)
    text = bpy.data.objects["Body"][RECORD]
    text.from_string(text.as_string()[:-300_000])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "damaged.blend"))
    extension.register()
    assert open_file(tmp_path / "damaged.blend") is None
    assert jobs.message.is_error
    assert jobs.message.text.startswith("The run in this file cannot be opened: what the file says of 'Body'")
    assert not bpy.data.objects["Body"].w2w.is_body
    assert bpy.data.objects["Body"].get(RECORD) is not None


CHANGES = (
    {"config.json": None},
    {"summary.json": b"{}"},
    {"clips.jsonl": b"{}"},
    {"utility.npz": b"PK"},
    {"names.json": b"[]"},
    {"names.json": b'{"collections": ["Patches"], "actions": {}, "signals": {}}'},
    {"names.json": b'{"collections": ["Patches", "Chosen patches"], "actions": 5, "signals": {}}'},
    {"../config.json": b"{}", "config.json": None},
)


def test_a_record_that_holds_something_else_is_refused(finished_run: Path) -> None:
    extension.unregister()
    bpy.ops.wm.open_mainfile(filepath=str(finished_run / "study.blend"), use_scripts=False)
    extension.register()
    mesh = bpy.data.objects["Body"]
    with ZipFile(io.BytesIO(base64.b64decode(mesh[RECORD].as_string()))) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    assert read_record(mesh)[0].config() == StudyResults.load(finished_run).config()
    for changed in CHANGES:
        packed = io.BytesIO()
        with ZipFile(packed, "w") as archive:
            for name, content in (files | changed).items():
                if content is not None:
                    archive.writestr(name, content)
        mesh[RECORD].from_string(base64.encodebytes(packed.getvalue()).decode())
        with pytest.raises(ValueError, match="what the file says of 'Body' is damaged"):
            read_record(mesh)


def test_names_in_a_file_lead_out_of_no_folder(opened: bpy.types.Object, tmp_path: Path) -> None:
    """Whoever made the file chose its clips' keys and names; none reads or writes elsewhere."""
    clip, cache = opened.w2w.clips[0], preferences.cache_folder()
    assert signal_cache.has(clip)
    kept = signal_cache.place_of(clip)
    for folder, file in (("signals", signals_file), (".w2w/features", features_file)):
        (tmp_path / folder).mkdir(parents=True)
        shutil.copy(file(*kept), tmp_path / f"mine{preferences.SIGNALS_SUFFIX}.npz")
    away = os.path.relpath(tmp_path / "mine", cache / "signals")
    clip.signals = away
    assert not signal_cache.has(clip)
    assert signal_cache.recording(clip) is None
    clip.signals, clip.stored_as = f"{STORED}{'0' * 32}", f"../{away}"
    assert not signal_cache.has(clip)


def test_use_active_mesh_brings_the_study_with_it(finished_run: Path) -> None:
    extension.unregister()
    bpy.ops.wm.open_mainfile(filepath=str(finished_run / "study.blend"), use_scripts=False)
    extension.register()
    bpy.context.view_layer.objects.active = bpy.data.objects["Body"]
    assert bpy.ops.w2w.use_mesh() == {"FINISHED"}
    study = bpy.context.scene.w2w.body.w2w
    assert len(study.clips) == 10
    assert utility_of(study) is not None
