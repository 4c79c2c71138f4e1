# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in a real Blender window under Xvfb: click through all steps, then compare states.

Needs the folder that `tools/real_blender.sh` sets up, a zip in dist/ that `tools/build_extension.py` made,
and the real clips; skips where one is missing. Pictures of every step go to the folder of `RESULTS`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from .sandbox import RESULTS, run_in_window

OUT = RESULTS / "window"

STEPS = (
    "0_empty",
    "1_body",
    "2_drop_fbx",
    "2_source_beside",
    "3_patches",
    "4_signals",
    "4_further",
    "4_own_part",
    "5_activities",
    "5_part_menu",
    "5_mean",
    "5_activity",
    "6_compare",
    "8_shape",
)
"""Pictures that must be there at least."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(shared_data: Path) -> dict[str, Any]:
    """What the click-through found."""
    variables = {"W2W_DATA": "/shared", "OMP_NUM_THREADS": "2"}
    return run_in_window("click_through.py", OUT, variables, shared_data)


def test_body_comes_and_goes_with_one_undo(report: dict[str, Any]) -> None:
    assert report["body"] == "Body"
    assert report["bodies_after_undo"] == 0
    assert report["bodies_after_redo"] == 2


def test_a_folder_of_real_clips_is_imported_and_nothing_else(report: dict[str, Any]) -> None:
    assert report["clips"] == report["usable"] >= 30
    assert len(report["activities"]) == 8
    assert report["objects_left_by_import"] == 0


def test_unusable_files_say_why_and_can_be_removed(report: dict[str, Any]) -> None:
    assert len(report["problems"]) == 5
    assert all(report["problems"].values())
    assert report["actions_from_problems"] == 0
    assert report["clips_after_removing_problems"] == report["clips"]


def test_the_source_can_be_shown_and_taken_away(report: dict[str, Any]) -> None:
    assert (report["source_shown"], report["source_left"]) == (1, 0)


def test_patches_are_placed_without_leftovers(report: dict[str, Any]) -> None:
    assert report["patches"] == report["empties_after_placing_again"] == 512


def test_baking_can_be_cancelled_undone_and_redone(report: dict[str, Any]) -> None:
    assert report["baked_after_esc"] == 0
    assert report["baked"] == report["baked_after_redo"] == report["usable"]
    assert report["baked_after_undo"] == 0
    assert "Bake Signals cancelled: nothing was changed" in report["messages"]


def test_further_sensors_are_ticked_one_by_one(report: dict[str, Any]) -> None:
    assert report["further"] == [["orientation", "magnetometer"], ["magnetometer"]]
    assert report["further_left"] == []


def test_activities_are_weighed_before_the_first_ranking(report: dict[str, Any]) -> None:
    assert report["weight_after_drag"] > 1
    assert report["parts_by_menu"] == ["BACKGROUND", "LEFT_OUT", "COUNTED"]


def test_ranking_shows_heatmaps_and_marks_the_best_spot(report: dict[str, Any]) -> None:
    assert report["heatmaps"] == 10  # and the mannequin's colours
    assert report["shown"] == "Expected F1"
    assert report["mean_f1_range"] == sorted(report["mean_f1_range"], reverse=True)
    assert report["target_after_drag"] < 0.9
    assert len(report["chosen"]) == 1
    assert report["shown_activity"] == "Expected F1: load_carrying"


def test_the_pick_tool_picks_and_compares(report: dict[str, Any]) -> None:
    assert report["tool"] == "w2w.pick_tool"
    assert report["picked_on_body"] >= 0
    assert report["compared_on_body"] >= 0
    assert report["compared_on_body"] != report["picked_on_body"]
    assert report["frame_while_playing"] != 12


def test_the_body_hides_what_is_on_its_back(report: dict[str, Any]) -> None:
    seen = report["in_sight"]
    assert all(seen["sternum"] + seen["abdomen"])
    assert not any(seen["scapula"] + seen["lower back"])


@pytest.mark.parametrize("what", ["import", "place", "rank", "target"])
def test_one_undo_takes_a_step_back_and_one_redo_brings_it_again(report: dict[str, Any], what: str) -> None:
    before, undone, redone = report["undo"][what]
    assert undone != before
    assert redone == before


def test_undoing_a_new_placing_brings_back_the_old_patches(report: dict[str, Any]) -> None:
    assert report["patches_after_undo"] == [True, 512]
    assert report["undo"]["import"][1] == 0
    assert report["undo"]["rank"][1] == [1, 0]  # the mannequin's colours


def test_files_dropped_on_the_viewport_are_imported(report: dict[str, Any]) -> None:
    assert set(report["dropped"]) == {".fbx", ".bvh"}
    assert all(n_frames > 10 and not problem for n_frames, problem in report["dropped"].values())
    assert report["clips_after_undoing_drops"] == [0, 0]


def test_a_shape_slider_reshapes_the_body_in_one_step_of_undo(report: dict[str, Any]) -> None:
    assert report["shape_changed"]
    assert report["heatmap_stays"]
    assert report["patches_stay"] == 512
    assert report["shape_undone"]
    assert report["gender_after_undo"] == 0


def test_a_saved_file_reopens_alike(report: dict[str, Any]) -> None:
    assert report["reopened_alike"] is True


@pytest.mark.usefixtures("report")
def test_every_step_has_its_picture() -> None:
    taken = {path.stem for path in (OUT / "pictures").glob("*.png")}
    assert set(STEPS) <= taken
