# SPDX-License-Identifier: GPL-3.0-or-later
"""What people come for: the example, a signal, places compared, the head forbidden, picture, film, own clips.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from .sandbox import RESULTS, inside, run_in_window
from .test_run_all_window import N_CLIPS, copy_clips

FREEZE_S = 3.0
"""The longest standstill of a job that draws, on a very busy machine; an idle one has none over .4 s."""

WINDOWS = [("1280", "800", "1"), ("1280", "800", "2"), ("1920", "1080", "1"), ("1920", "1080", "2")]
"""Width and height, pixels, and the scale of the interface."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=WINDOWS, ids="-".join)
def report(request: pytest.FixtureRequest, shared_data: Path) -> dict[str, Any]:
    """What the window showed."""
    width, height, scale = request.param
    out = RESULTS / f"tasks_{width}_{scale}"
    variables = {"W2W_CLIPS": inside(copy_clips(shared_data, out)), "W2W_SCALE": scale}
    return run_in_window("tasks.py", out, variables, window=(width, height)) | {"scale": float(scale)}


def test_one_click_gives_a_map_of_a_body_that_fills_the_view(report: dict[str, Any]) -> None:
    example = report["example"]
    assert example["clips"] >= 20
    assert example["patch"] is not None
    assert example["is_marked"]
    assert example["share"] > (0.8 if report["scale"] == 1 else 0.4)  # its arms fill a narrow view first


def test_a_clicked_spot_has_a_card_beside_the_body_that_closes(report: dict[str, Any]) -> None:
    card = report["card"]
    assert card["picked"] >= 0
    assert card["closed"] == -1
    assert card["covers"] == [0]


def test_known_products_are_compared_though_one_word_is_unknown(report: dict[str, Any]) -> None:
    names, unknown = report["compared"]
    assert names == ["ring", "watch"]
    assert "tail" in unknown


def test_two_clicked_spots_have_a_card_each(report: dict[str, Any]) -> None:
    two = report["two"]
    assert len({*two["picked"], -1}) == 3
    assert two["covers"] == [0, 0]
    assert two["closed"] == -1


def test_the_answer_keeps_off_what_is_forbidden(report: dict[str, Any]) -> None:
    assert report["wishes"] == [["FORBID", "head"]]
    assert "head" not in report["forbidden"]


def test_a_picture_is_saved_and_opens(report: dict[str, Any]) -> None:
    assert report["picture"] == [True, "IMAGE_EDITOR"]


def test_a_film_stops_by_esc_and_a_short_one_is_written_and_plays(report: dict[str, Any]) -> None:
    film = report["film"]
    assert film["stopped"] == [True, []]
    assert film["files"] == ["film.mp4"]
    assert film["frames"] == [6, 480, 270]
    assert film["players"] == 1
    for freeze, _ in (film["freeze"], report["picture_freeze"]):
        assert 0 < freeze < FREEZE_S


def test_a_mended_label_makes_the_answer_out_of_date(report: dict[str, Any]) -> None:
    mended, outdated = report["mended"]
    assert mended == 1
    assert outdated


def test_a_file_that_is_opened_again_shows_its_answer(report: dict[str, Any]) -> None:
    assert report["reopened"] == ["ANSWER", True]


def test_own_clips_come_in_by_the_second_button(report: dict[str, Any]) -> None:
    assert report["own"] == N_CLIPS
    assert report["own_patch"] is not None
