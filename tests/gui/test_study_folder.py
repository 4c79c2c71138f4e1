# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, Save As, a folder that was moved, a file that travels alone: a study keeps or says what it has.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from ..made_run import make_run
from .sandbox import RESULTS, inside, newest_zip, run_in_window

OUT = RESULTS / "study_folder"
PLACES = Path(inside(OUT)) / "places"
N_CLIPS = 9
PICTURES = {"1_lost", "2_located", "3_alone", "4_saved"}

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(shared_data: Path) -> dict[str, Any]:
    """What the window showed."""
    newest_zip()  # skips before the run where the window cannot be tried
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    return run_in_window("study_folder.py", OUT, {"W2W_RUN": inside(make_run(shared_data, OUT))})


def has_all(state: dict[str, Any]) -> bool:
    """Whether all signals are there and the ranking is of them."""
    return (state["signals"], state["read"], state["to_bake"]) == (N_CLIPS, N_CLIPS, 0) and state["is_ranked"]


def test_undo_brings_back_signals_and_ranking_of_the_settings_before(report: dict[str, Any]) -> None:
    assert has_all(report["opened"])
    assert has_all(report["other_sensor"])
    assert report["other_sensor"]["sensor"] == "watch"
    assert not report["ranking_undone"]["is_ranked"]
    assert report["ranking_undone"]["to_bake"] == 0
    assert report["baking_undone"]["to_bake"] == N_CLIPS
    assert report["sensor_undone"] == report["opened"]
    assert report["redone"] == report["other_sensor"]


def test_a_file_finds_its_folder_when_both_move_or_it_is_saved_elsewhere(
    report: dict[str, Any],
) -> None:
    for step in ("both_moved", "saved_as"):
        assert has_all(report[step])
        assert report[step]["folder"] == str(PLACES / "elsewhere" / "results")


def test_a_folder_that_was_moved_is_said_and_located(report: dict[str, Any]) -> None:
    assert (report["lost"]["signals"], report["lost"]["is_ranked"]) == (0, True)
    assert report["lost"]["folder"] == str(PLACES / "elsewhere" / "results")
    assert has_all(report["located"])
    assert report["located"]["message"] == f"Found the signals of {N_CLIPS} clips in {PLACES / 'moved'}"
    assert report["locating_undone"] == report["lost"]
    assert has_all(report["located_and_opened"])
    assert report["located_and_opened"]["folder"] == str(PLACES / "moved")


def test_a_file_that_travels_alone_shows_its_heatmaps_and_can_bake(report: dict[str, Any]) -> None:
    assert report["alone"]["signals"] == 0
    assert report["alone"]["has_ranking"]
    assert report["alone"]["heatmaps"] == report["opened"]["heatmaps"]
    assert report["alone"]["folder"] == str(PLACES / "moved")
    assert (report["baked_alone"]["signals"], report["baked_alone"]["to_bake"]) == (N_CLIPS, 0)


def test_a_saved_study_works_in_its_folder(report: dict[str, Any]) -> None:
    assert has_all(report["saved"])
    assert report["saved"]["folder"] == str(PLACES / "saved")
    assert has_all(report["saving_undone"])
    assert report["saving_undone"]["folder"] == str(PLACES / "moved")
    assert has_all(report["opened_without_cache"])


@pytest.mark.usefixtures("report")
def test_every_step_has_its_picture() -> None:
    assert {path.stem for path in (OUT / "pictures").glob("*.png")} == PICTURES
