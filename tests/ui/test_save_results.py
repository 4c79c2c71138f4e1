# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's study as a results folder: what reads a run's folder reads it too."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import bpy
import numpy as np
import pytest
import scipy
from typer.testing import CliRunner

import w2w
from w2w.core.files import file_sha256
from w2w.core.findings.summary import versions
from w2w.core.motion.skinning import patch_matrices
from w2w.core.study.results import StudyResults
from w2w.headless.app import APP
from w2w.ui.files.save_results import save_steps
from w2w.ui.jobs import jobs
from w2w.ui.steps.baking import to_bake
from w2w.ui.study import signal_cache
from w2w.ui.study.lists import advice_of
from w2w.ui.study.state import rank_settings, utility_of

from ..clip_lists import skipped_clips, used_clips
from .made_study import make_study
from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def save(folder: Path) -> dict:
    """Save the panel's study; gives what the summary says."""
    assert bpy.ops.w2w.save_results(directory=str(folder)) == {"FINISHED"}
    return json.loads((folder / "summary.json").read_text())


def content(folder: Path) -> list[str]:
    """Everything in a folder."""
    walked = os.walk(folder)  # bears that a thread removes a folder meanwhile
    names = ((where, name) for where, folders, files in walked for name in (*folders, *files))
    return sorted(Path(where, name).relative_to(folder).as_posix() for where, name in names)


@pytest.mark.slow
def test_the_command_line_and_python_read_a_study_of_the_panel(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    summary = save(tmp_path / "saved")
    assert jobs.message.text == f"Saved 9 clips and their ranking in {tmp_path / 'saved'}"
    assert summary["answer"]["patch"] == body.w2w.chosen[0].patch
    for command in (["place"], ["tables"], ["report"]):
        done = CliRunner().invoke(APP, [*command, str(tmp_path / "saved")])
        assert done.exit_code == 0, done.output
    assert (tmp_path / "saved" / "report.html").is_file()
    ranking = w2w.open_results(tmp_path / "saved")
    np.testing.assert_array_equal(ranking.utility.f1, utility_of(body.w2w).f1)
    assert ranking.answer.patch == body.w2w.chosen[0].patch


@pytest.mark.slow
def test_a_folder_of_the_panel_names_versions_and_inputs(
    library: Path, finished_run: Path, tmp_path: Path
) -> None:
    body = make_study(library)
    file = Path(body.w2w.clips[4].file)
    save(tmp_path / "saved")
    config = json.loads((tmp_path / "saved" / "config.json").read_text())
    assert config["versions"] == versions()
    assert config["versions"]["scipy"] == scipy.__version__
    assert config["clips"]["sha256"] == file_sha256(tmp_path / "saved" / "clips.jsonl")
    saved = hashes(tmp_path / "saved")
    assert saved[f"{file.parent.name}_{file.stem}".replace(" ", "_")] == file_sha256(file)
    assert set(saved.values()) == {file_sha256(file) for file in library.rglob("*.npz")}
    open_file(finished_run / "study.blend")
    save(tmp_path / "again")
    assert hashes(tmp_path / "again") == hashes(finished_run)


@pytest.mark.slow
def test_a_file_changed_since_it_was_imported_is_named_as_it_was(library: Path, tmp_path: Path) -> None:
    folder = tmp_path / "own"
    shutil.copytree(library, folder)
    body = make_study(folder)
    file = Path(body.w2w.clips[0].file)
    sha256 = file_sha256(file)
    file.write_bytes(b"another take")
    save(tmp_path / "saved")
    assert sha256 in hashes(tmp_path / "saved").values()


def hashes(out: Path) -> dict[str, str]:
    return {entry["file"]: entry["sha256"] for entry in used_clips(out)}


@pytest.mark.later
def test_a_saved_study_works_in_its_folder_and_opens_again(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    body.w2w.max_places = 1
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    worn, f1 = advice_of(body.w2w), utility_of(body.w2w).f1
    acc = signal_cache.recording(body.w2w.clips[2]).acc
    save(tmp_path / "saved")
    bpy.ops.w2w.clear_cache()
    signal_cache._recordings.clear()
    assert body.w2w.results_folder == str(tmp_path / "saved")
    assert all(signal_cache.has(clip) for clip in body.w2w.clips)
    assert body.w2w.ranked_as == rank_settings(body.w2w)
    assert advice_of(body.w2w) == worn
    assert not to_bake(body.w2w)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "study.blend"))
    (tmp_path / "saved").rename(tmp_path / "away")
    body = open_file(tmp_path / "study.blend")
    assert bpy.ops.w2w.locate_results(filepath=str(tmp_path / "away")) == {"FINISHED"}
    np.testing.assert_array_equal(signal_cache.recording(body.w2w.clips[2]).acc, acc)
    assert not to_bake(body.w2w)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert bpy.ops.w2w.open_results(filepath=str(tmp_path / "away")) == {"FINISHED"}
    again = bpy.context.scene.w2w.body
    np.testing.assert_array_equal(utility_of(again.w2w).f1, f1)
    np.testing.assert_array_equal(signal_cache.recording(again.w2w.clips[2]).acc, acc)


@pytest.mark.slow
def test_what_was_changed_in_blender_goes_back_into_a_folder(finished_run: Path, tmp_path: Path) -> None:
    run = StudyResults.load(finished_run)
    body = open_file(finished_run / "study.blend")
    body.w2w.target, body.w2w.max_places = 1.0, 2
    summary = save(tmp_path / "saved")
    saved = StudyResults.load(tmp_path / "saved")
    np.testing.assert_array_equal(saved.utility.f1, run.utility.f1)
    assert saved.clips == run.clips
    assert saved.config().constraints == run.config().constraints
    assert (saved.config().target, saved.config().max_places) == (1.0, 2)
    assert saved.config().windows == run.config().windows
    assert summary["answer"]["patch"] == body.w2w.chosen[0].patch
    assert skipped_clips(tmp_path / "saved") == skipped_clips(run.out)
    name = run.clips[4].name
    np.testing.assert_allclose(
        patch_matrices(saved.body(), saved.patches.triangles, saved.motion(name)),
        patch_matrices(run.body(), run.patches.triangles, run.motion(name)),
        atol=1e-4,
    )


@pytest.mark.slow
def test_an_activity_that_is_not_ticked_is_left_out_and_said(finished_run: Path, tmp_path: Path) -> None:
    body = open_file(finished_run / "study.blend")
    body.w2w.activities["run"].part, body.w2w.max_places = "LEFT_OUT", 1
    summary = save(tmp_path / "saved")
    assert jobs.message.text.endswith("ranked anew without run")
    saved = StudyResults.load(tmp_path / "saved")
    assert saved.utility.activities == ("bow", "walk_left")
    assert summary["clips"] == {"found": 10, "used": 6, "ranked": 6, "skipped": 4}
    assert {"run is left out"} < set(skipped_clips(tmp_path / "saved").values())


def test_a_folder_with_something_in_it_is_left_alone(finished_run: Path, tmp_path: Path) -> None:
    open_file(finished_run / "study.blend")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    with pytest.raises(RuntimeError, match="is not empty: choose a new folder for the results"):
        bpy.ops.w2w.save_results(directory=str(tmp_path / "mine"))
    assert content(tmp_path) == ["mine", "mine/thesis.txt"]


def test_a_ranking_of_other_clips_is_not_saved(finished_run: Path, tmp_path: Path) -> None:
    body = open_file(finished_run / "study.blend")
    body.w2w.clips[0].activity = "greeting"
    with pytest.raises(RuntimeError, match="rank again first"):
        bpy.ops.w2w.save_results(directory=str(tmp_path / "saved"))
    assert not content(tmp_path)


@pytest.mark.slow
def test_esc_leaves_no_half_written_folder(finished_run: Path, tmp_path: Path) -> None:
    body = open_file(finished_run / "study.blend")
    body.w2w.max_places = 1
    steps = save_steps(body, tmp_path / "saved")
    while next(steps).fraction <= 0.8:
        pass
    steps.close()
    for _ in range(1200):  # the thread ends at its next step
        if not content(tmp_path):
            break
        time.sleep(0.05)
    assert not content(tmp_path)
