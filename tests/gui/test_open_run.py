# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run left opens in a real Blender window: its file, and its folder dropped on another scene.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from ..made_run import make_run
from .sandbox import RESULTS, inside, is_outliner_folded, newest_zip, run_in_window

OUT = RESULTS / "run"
N_PATCHES = 512
PICTURES = (
    "1_opened",
    "2_ranking",
    "3_signals",
    "4_choosing",
    "5_dropped",
    "6_two_maps",
    "7_background",
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(shared_data: Path) -> Path:
    """The results folder of a run with as many patches as people take."""
    newest_zip()  # skips before the run where the window cannot be tried
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    return make_run(shared_data, OUT, N_PATCHES)


@pytest.fixture(scope="module")
def report(results: Path) -> dict[str, Any]:
    """What the window showed."""
    return run_in_window("open_run.py", OUT, {"W2W_RUN": inside(results)})


@pytest.mark.parametrize("way", ["enabled_late", "opened", "dropped"])
def test_the_panel_shows_the_run(report: dict[str, Any], results: Path, way: str) -> None:
    best = json.loads((results / "summary.json").read_text())["answer"]["patch"]
    found = report[way]
    assert found["message"] == f"Opened a finished run: 9 clips on {N_PATCHES} spots"
    assert (found["clips"], found["baked"], found["patches"]) == (9, 9, N_PATCHES)
    assert found["keys"] > 20
    assert found["chosen"] == [best]
    assert found["regions"] == 8
    assert found["heatmaps"] == 5  # of the three activities, their mean, and the mannequin
    assert found["up_to_date"]


def test_patches_of_a_run_are_folded_in_the_outliner(report: dict[str, Any]) -> None:
    assert is_outliner_folded(OUT / "pictures" / "1_opened.png", report["outliner"])


def test_a_row_of_the_ranking_can_be_clicked(report: dict[str, Any]) -> None:
    assert report["picked"] in report["worn"]  # the set to wear together comes first


def test_undo_keeps_the_study(report: dict[str, Any]) -> None:
    assert report["clips_after_undo"] == 10


def test_the_set_to_wear_is_shown_and_a_new_choice_can_be_cancelled(
    report: dict[str, Any], results: Path
) -> None:
    worn = json.loads((results / "summary.json").read_text())["worn_together"]
    assert report["worn"] == [place["patch"] for place in worn["places"]]
    assert report["choosing"]
    assert report["message_after_esc"] == "Choose Sensors cancelled: nothing was changed"


def test_two_maps_stand_side_by_side_until_the_button_is_pressed_again(report: dict[str, Any]) -> None:
    assert report["two_maps"] == ["bow", "run"]
    assert not report["beside_after_second_press"]


def test_an_activity_as_background_changes_the_table_at_once(report: dict[str, Any]) -> None:
    assert report["background_changes_the_table"]


def test_a_deleted_body_takes_its_patches_along_and_undo_brings_them_back(report: dict[str, Any]) -> None:
    there, gone = N_PATCHES + 2, 1  # the body and its armature
    assert report["objects_by_delete_undo_redo"] == [there, gone, there, gone]


@pytest.mark.usefixtures("report")
def test_every_step_has_its_picture() -> None:
    assert set(PICTURES) <= {path.stem for path in (OUT / "pictures").glob("*.png")}
