# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's first scene, as it is, to a map in sight, a clip that plays and a picture to show.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from .sandbox import RESULTS, inside, run_in_window
from .test_run_all_window import copy_clips

SIZES = {("1280", "800"): "WORKBENCH CYCLES EEVEE", ("1920", "1080"): ""}
"""Sizes of windows, and the engines that render there: Eevee takes a minute without a graphics card."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=SIZES, ids="x".join)
def report(request: pytest.FixtureRequest, shared_data: Path) -> dict[str, Any]:
    """What a window of this size showed."""
    out = RESULTS / f"first_minutes_{request.param[0]}"
    variables = {"W2W_CLIPS": inside(copy_clips(shared_data, out)), "W2W_RENDER": SIZES[request.param]}
    return run_in_window("first_minutes.py", out, variables, window=request.param)


def test_the_default_cube_camera_and_light_are_there(report: dict[str, Any]) -> None:
    assert report["things"] == ["Camera", "Cube", "Light"]


def test_the_whole_body_shows_the_map(report: dict[str, Any]) -> None:
    counts = report["shown"].values()
    assert len(counts) > 60
    assert sum(shown for shown, _ in counts) > 0.95 * sum(total for _, total in counts)
    # a part with a single patch or two in sight lies on the outline
    assert all(shown > total / 2 for shown, total in counts if total > 2), report["shown"]


def test_the_sentence_is_read_without_scrolling(report: dict[str, Any]) -> None:
    sentence = report["sentence"]
    assert sentence["answer"] in sentence["text"]
    assert abs(sentence["scrolled"]) <= 2  # pixels
    assert sentence["widest"] <= 1
    assert sentence["height"] < 0.6


def test_preview_plays_and_stops(report: dict[str, Any]) -> None:
    assert report["frames_played"] > 5
    assert report["playing"] == [True, False, True, False]


def test_products_are_compared(report: dict[str, Any]) -> None:
    assert sorted(report["compared"]) == ["necklace", "ring"]


def test_the_picture_to_show_has_body_legend_and_badges(report: dict[str, Any]) -> None:
    picture = report["presentation"]
    assert picture["scenes"] == 1
    assert picture["colours"] > 50_000
    assert picture["colours_of_legend"] > 100
    assert picture["ink"] > 1000
    assert picture["shape"] == pytest.approx(16 / 9, abs=0.01)
    assert report["windows"][1:] == ["IMAGE_EDITOR"]
    height, width = report["alone"]["size"]
    assert height == width
    assert report["alone"]["colours"] > 20_000


def test_renders_show_the_map_in_every_engine(report: dict[str, Any]) -> None:
    if "rendered" not in report:
        pytest.skip("nothing is rendered at this size")
    assert sorted(report["rendered"]) == ["CYCLES", "EEVEE", "WORKBENCH"]
    assert min(report["rendered"].values()) > 300, report["rendered"]
