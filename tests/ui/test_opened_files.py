# SPDX-License-Identifier: GPL-3.0-or-later
"""Where signals are found when the file, its results folder or both have moved."""

from __future__ import annotations

import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.files import write_npz
from w2w.core.imu.recording import ImuRecording
from w2w.core.study.clip_files import signals_file
from w2w.ui.files.open_results import misses_folder
from w2w.ui.jobs import jobs
from w2w.ui.study import signal_cache
from w2w.ui.study.state import rank_settings, utility_of

from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


@pytest.fixture
def moved(finished_run: Path, tmp_path: Path) -> Path:
    """The results folder, brought to another machine."""
    return Path(shutil.copytree(finished_run, tmp_path / "there" / "results"))


def test_a_folder_that_moved_brings_its_signals(moved: Path) -> None:
    body = open_file(moved / "study.blend")
    assert Path(body.w2w.results_folder) == moved.resolve()
    assert all(signal_cache.has(clip) for clip in body.w2w.clips if clip.action)


@pytest.mark.slow
def test_a_file_without_its_folder_shows_the_ranking_and_says_what_is_missing(
    moved: Path, tmp_path: Path
) -> None:
    shutil.move(moved / "study.blend", tmp_path / "alone.blend")
    shutil.rmtree(moved)
    body = open_file(tmp_path / "alone.blend")
    assert utility_of(body.w2w).f1.shape == (24, 3)
    assert len(body.w2w.chosen)
    assert jobs.message.text == (
        "Opened a finished run: 9 clips on 24 spots. The signals of 9 clips are not next to this file: "
        "locate the results folder, or bake them again (page Details)"
    )
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    assert all(signal_cache.has(clip) for clip in body.w2w.clips if clip.action)


@pytest.mark.slow
def test_a_file_saved_elsewhere_finds_the_folder_where_it_was_and_when_both_moved(
    moved: Path, tmp_path: Path
) -> None:
    open_file(moved / "study.blend")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "there" / "mine.blend"))
    body = open_file(tmp_path / "there" / "mine.blend")
    assert Path(body.w2w.results_folder) == moved.resolve()
    (tmp_path / "there").rename(tmp_path / "elsewhere")
    body = open_file(tmp_path / "elsewhere" / "mine.blend")
    assert Path(body.w2w.results_folder) == (tmp_path / "elsewhere" / "results").resolve()
    bpy.ops.wm.save_mainfile()
    (tmp_path / "elsewhere" / "mine.blend").rename(tmp_path / "mine.blend")
    body = open_file(tmp_path / "mine.blend")
    assert Path(body.w2w.results_folder) == (tmp_path / "elsewhere" / "results").resolve()
    assert signal_cache.recording(body.w2w.clips[0]) is not None


def test_a_folder_that_was_moved_away_is_located(moved: Path, tmp_path: Path) -> None:
    shutil.move(moved / "study.blend", tmp_path / "alone.blend")
    moved.rename(tmp_path / "away")
    body = open_file(tmp_path / "alone.blend")
    settings = rank_settings(body.w2w)
    assert misses_folder(body.w2w)
    (tmp_path / "other").mkdir()
    with pytest.raises(RuntimeError, match="other does not hold the signals of this study"):
        bpy.ops.w2w.locate_results(filepath=str(tmp_path / "other" / "summary.json"))
    assert bpy.ops.w2w.locate_results(filepath=str(tmp_path / "away" / "summary.json")) == {"FINISHED"}
    assert jobs.message.text == f"Found the signals of 9 clips in {tmp_path / 'away'}"
    assert not bpy.ops.w2w.locate_results.poll()
    assert rank_settings(body.w2w) == settings
    assert signal_cache.recording(body.w2w.clips[0]) is not None


def test_signals_that_were_made_anew_since_are_not_taken_for_the_runs(moved: Path) -> None:
    body = open_file(moved / "study.blend")
    clip = body.w2w.clips[0]
    path = signals_file(moved, clip.name)
    stored = ImuRecording.load(path)
    write_npz(path, {"acc": stored.acc + np.float32(1), "gyr": stored.gyr, "rate": np.array(stored.rate)})
    assert not signal_cache.has(clip)
    assert signal_cache.recording(clip) is None


def test_a_files_word_leads_nowhere_but_into_a_results_folder(moved: Path) -> None:
    body = open_file(moved / "study.blend")
    clip = body.w2w.clips[0]
    shutil.copy(signals_file(moved, clip.name), moved.parent / "other.npz")
    clip.stored_as, clip.signals = "../../other", "run-0"
    bpy.ops.wm.save_as_mainfile(filepath=str(moved / "changed.blend"))
    body = open_file(moved / "changed.blend")
    assert not signal_cache.has(body.w2w.clips[0])
    assert signal_cache.recording(body.w2w.clips[0]) is None
