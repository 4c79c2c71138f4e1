# SPDX-License-Identifier: GPL-3.0-or-later
"""Other themes, languages, scales and sensors than Blender starts with, and an import that is cancelled.

Needs what `test_window.py` needs; skips where one is missing. Pictures of themes and scales are for people.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from .sandbox import RESULTS, inside, is_outliner_folded, run_in_window
from .test_run_all_window import N_CLIPS, copy_clips

OUT = RESULTS / "other_settings"
VIEW = (250, 250, 640, 760)
"""The body in the 3D view."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(shared_data: Path) -> dict[str, Any]:
    """What the window showed."""
    clips = copy_clips(shared_data, OUT)
    return run_in_window("other_settings.py", OUT, {"W2W_CLIPS": inside(clips)})


def picture(name: str, left: int, top: int, right: int, bottom: int) -> np.ndarray:
    """Part of a picture as an array (H, W, 3)."""
    with Image.open(OUT / "pictures" / f"{name}.png") as image:
        return np.array(image.convert("RGB").crop((left, top, right, bottom))).astype(int)


def test_an_import_cancelled_in_its_middle_leaves_nothing(report: dict[str, Any]) -> None:
    assert report["messages"][0] == "Import Motions cancelled: nothing was changed"
    assert report["left_by_cancel"] == [0, 0]
    assert report["clips"] == N_CLIPS


def test_patches_stay_folded_in_the_outliner(report: dict[str, Any]) -> None:
    assert is_outliner_folded(OUT / "pictures" / "2_folded.png", report["outliner"])


@pytest.mark.usefixtures("report")
def test_patches_that_are_shown_have_the_colours_of_their_scores() -> None:
    before, after = picture("2_folded", *VIEW), picture("2_patches", *VIEW)
    changed = abs(after - before).max(axis=-1) > 20
    coloured = changed & (np.ptp(after, axis=-1) > 60)
    assert coloured.sum() > 300


def test_two_maps_are_shown_whole_beside_a_wide_sidebar_and_in_local_view(report: dict[str, Any]) -> None:
    assert report["widened"] > 150
    left, right, bottom, top = report["free"]
    for body in report["shown"]:
        assert all(left < x < right and bottom < y < top for x, y in body["spots"])
        x, y = body["middle"]
        assert np.ptp(picture("2_wide", x - 2, y - 2, x + 3, y + 3), axis=-1).min() > 40  # it has a colour


def test_a_badge_goes_with_what_covers_it(report: dict[str, Any]) -> None:
    assert report["badge_in_sight"] == [True, False]


def test_an_own_part_is_chosen_from_the_menu(report: dict[str, Any]) -> None:
    assert report["sensors"] == [["OWN", "own part"], ["bmi270", "bmi270"]]


def test_an_own_part_is_edited_undone_saved_and_loaded(report: dict[str, Any]) -> None:
    started, typed, dragged, undone, loaded = report["edited"]
    assert started[:2] == ["OWN", "own part"]
    assert typed == ["OWN", "wrist pod", 4.0, started[3]]
    assert dragged[3] > typed[3]
    assert undone == typed
    assert report["saved"] == ["wrist_pod.json"]
    assert loaded == typed


def test_a_pen_that_slides_picks_where_it_came_down(report: dict[str, Any]) -> None:
    (chest,), (first, thigh) = report["tapped"]
    assert "chest" in chest
    assert (first, "thigh" in thigh) == (chest, True)


def test_a_click_picks_the_same_patch_in_two_windows_at_two_scales(report: dict[str, Any]) -> None:
    assert len(report["picked"]) == 4
    assert len(set(report["picked"])) == 1
    assert report["picked"][0] >= 0


def test_the_sidebar_has_one_language(report: dict[str, Any]) -> None:
    x, y, width, height = report["sidebar"]
    english, german = (picture(f"5_{name}", x, y, x + width - 40, y + height) for name in ("en_US", "de_DE"))
    assert (abs(english - german).max(axis=-1) > 40).mean() < 0.001
