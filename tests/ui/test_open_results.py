# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder opened into any scene: as if it had been computed there."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.motion.skinning import patch_matrices
from w2w.core.study.clip_files import mark_changing, motion_file, signals_file
from w2w.core.study.results import StudyResults
from w2w.scene.bake import PatchBaker
from w2w.scene.base.body import armature_of, body_of
from w2w.scene.base.steps import without_pauses
from w2w.ui.files.open_results import open_steps
from w2w.ui.jobs import jobs
from w2w.ui.study import lists, signal_cache
from w2w.ui.study.lists import answer_of
from w2w.ui.study.state import (
    BAKED,
    FAILED,
    bake_settings,
    bodies,
    config_of,
    patches_of,
    rank_settings,
    state_of,
    utility_of,
)
from w2w.ui.viewport.framing import extent

from ..scene.conftest import difference
from ..sensor_steps import assert_same_to_one_step
from .made_study import names_in_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


@pytest.fixture
def opened(finished_run: Path) -> bpy.types.Object:
    """The run's body, in a scene that holds another body and plays 25 frames a second."""
    bpy.context.scene.render.fps = 25
    bpy.ops.w2w.add_body()
    assert bpy.ops.w2w.open_results(filepath=str(finished_run / "summary.json")) == {"FINISHED"}
    return bpy.context.scene.w2w.body


def test_each_clip_of_a_run_lets_the_window_have_its_turn(
    finished_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lists, "listed_spelling", lambda *_: pytest.fail("labels are spelled by all others"))
    texts = [step.text for step in open_steps(finished_run)]
    assert {clip.name for clip in bpy.context.scene.w2w.body.w2w.clips if clip.action} <= {*texts}


def test_all_of_the_run_is_there(opened: bpy.types.Object, finished_run: Path, summary: dict) -> None:
    study, run = opened.w2w, StudyResults.load(finished_run)
    assert jobs.message.text == "Opened a finished run: 9 clips on 24 spots"
    np.testing.assert_array_equal(utility_of(study).f1, run.utility.f1)
    np.testing.assert_array_equal(patches_of(opened).triangles, run.patches.triangles)
    np.testing.assert_allclose(body_of(opened).vertices, run.body().vertices, atol=1e-6)
    assert [place.patch for place in study.chosen] == [summary["answer"]["patch"]]
    assert answer_of(study) == summary["answer"]
    states = [state_of(clip, bake_settings(study)) for clip in study.clips]
    assert states == [BAKED] * 9 + [FAILED]
    assert study.ranked_as == rank_settings(study)
    assert config_of(study) == run.config()
    assert study.has_shape
    clip = study.clips[3]
    stored = ImuRecording.load(signals_file(finished_run, clip.name))
    np.testing.assert_array_equal(signal_cache.recording(clip).gyr, stored.gyr)


@pytest.mark.slow
def test_signals_that_the_run_did_not_keep_are_made_again(finished_run: Path, tmp_path: Path) -> None:
    lean = tmp_path / "lean"
    shutil.copytree(finished_run, lean)
    shutil.rmtree(lean / "signals")
    assert bpy.ops.w2w.open_results(filepath=str(lean / "summary.json")) == {"FINISHED"}
    study = bpy.context.scene.w2w.body.w2w
    assert [state_of(clip, bake_settings(study)) for clip in study.clips] == [BAKED] * 9 + [FAILED]
    for clip in study.clips[:9]:
        stored = ImuRecording.load(signals_file(finished_run, clip.name))
        assert_same_to_one_step(signal_cache.recording(clip), stored, config_of(study).sensor_model())


def test_motions_keep_their_speed_and_the_patches_ride(opened: bpy.types.Object, finished_run: Path) -> None:
    run, clip = StudyResults.load(finished_run), opened.w2w.clips[4]
    baker = PatchBaker(opened, patches_of(opened))
    bake = without_pauses(baker.by_frame(clip.action))
    assert bake.rate == pytest.approx(run.motion(clip.name).rate, rel=1e-5)
    truth = patch_matrices(run.body(), run.patches.triangles, run.motion(clip.name))
    truth[..., :3, 3] += armature_of(opened).location
    distance, _ = difference(bake.matrices, truth)
    assert distance < 1e-4


def test_it_stands_beside_the_body_that_is_there_and_is_named_after_its_folder(
    opened: bpy.types.Object, finished_run: Path
) -> None:
    other = next(item for item in bodies(bpy.context.scene) if item is not opened)
    assert opened.name == finished_run.name
    (_, right), (left, _) = extent([other]), extent([opened])
    assert 0 < left[0] - right[0] < 1.0


def test_a_motion_that_is_gone_costs_its_clip_alone(finished_run: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(finished_run, tmp_path / "results"))
    gone = StudyResults.load(folder).clips[0].name
    motion_file(folder, gone).unlink()
    assert bpy.ops.w2w.open_results(filepath=str(folder)) == {"FINISHED"}
    clips = bpy.context.scene.w2w.body.w2w.clips
    assert clips[gone].problem == "its motion is no longer where the run left it"
    assert [clip.action is not None for clip in clips] == [False, *[True] * 8, False]


@pytest.mark.parametrize("lost", ["summary.json", "utility.npz", ".w2w/body.npz"])
def test_what_is_no_results_folder_says_why_and_leaves_nothing(
    finished_run: Path, tmp_path: Path, lost: str
) -> None:
    folder = Path(shutil.copytree(finished_run, tmp_path / "results"))
    (folder / lost).unlink()
    before = names_in_file()
    with pytest.raises(RuntimeError, match=Path(lost).name):
        bpy.ops.w2w.open_results(filepath=str(folder))
    assert jobs.message.is_error
    assert jobs.message.text.startswith(f"{folder} is not the ")
    assert names_in_file() == before


@pytest.mark.parametrize("away", ["summary.json", "clips.jsonl", ".w2w", "motions", "signals"])
def test_a_link_that_leads_out_of_the_folder_is_not_followed(
    finished_run: Path, tmp_path: Path, away: str
) -> None:
    folder = Path(shutil.copytree(finished_run, tmp_path / "results"))
    (folder / away).rename(tmp_path / "elsewhere")
    (folder / away).symlink_to(tmp_path / "elsewhere")
    before = names_in_file()
    with pytest.raises(RuntimeError, match="is a link that leads out of the folder"):
        bpy.ops.w2w.open_results(filepath=str(folder))
    assert names_in_file() == before


def test_a_clip_whose_name_leads_out_of_the_folder_is_refused(finished_run: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(finished_run, tmp_path / "results"))
    first, *others = (folder / "clips.jsonl").read_text("utf-8").splitlines()
    lines = [first, json.dumps(json.loads(others[0]) | {"clip": "../../mine"}), *others[1:]]
    (folder / "clips.jsonl").write_text("\n".join(lines), "utf-8")
    with pytest.raises(RuntimeError, match=r"clips\.jsonl, line 2, names '\.\./\.\./mine'"):
        bpy.ops.w2w.open_results(filepath=str(folder))


def test_an_unfinished_run_is_said_to_be_so(finished_run: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(finished_run, tmp_path / "results"))
    mark_changing(folder)
    with pytest.raises(RuntimeError, match="run the same command again to finish it"):
        bpy.ops.w2w.open_results(filepath=str(folder))
    assert jobs.message.text.startswith(f"{folder} holds an unfinished run")


def test_esc_leaves_the_scene_as_it_was(finished_run: Path) -> None:
    bpy.ops.w2w.add_body()
    body, before = bpy.context.scene.w2w.body, names_in_file()
    steps = open_steps(finished_run)
    while next(steps).fraction < 0.8:
        pass
    assert names_in_file() != before
    steps.close()
    assert names_in_file() == before
    assert bpy.context.scene.w2w.body == body
