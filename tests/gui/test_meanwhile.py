# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do besides in a real Blender window costs a job at most: never a result, a file or the panel.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from .sandbox import RESULTS, inside, run_in_window
from .test_run_all_window import N_CLIPS, copy_clips

OUT = RESULTS / "meanwhile"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(shared_data: Path) -> dict[str, Any]:
    """What the window showed."""
    clips = copy_clips(shared_data, OUT)
    return run_in_window("meanwhile.py", OUT, {"W2W_CLIPS": inside(clips)})


def test_another_frame_rate_of_the_scene_changes_no_signal_and_no_speed(report: dict[str, Any]) -> None:
    first, later = report["signals"]
    assert len(set(first)) == N_CLIPS
    assert later == first
    np.testing.assert_allclose(*report["wrist"], atol=1e-5)
    before, after = report["preview_seconds"]
    assert after == pytest.approx(before, abs=0.5 / 24)


def test_a_job_holds_input_back_from_every_window_and_then_no_more(report: dict[str, Any]) -> None:
    assert report["modes"] == [[True, "OBJECT"]] * 3
    assert report["mode_afterwards"] == ["EDIT", "OBJECT"]


@pytest.mark.usefixtures("report")
def test_the_status_bar_of_another_window_shows_the_job_until_it_is_over() -> None:
    before, running, over = (status_bar(name) for name in ("2_two_windows", "2_running", "2_over"))
    assert running != before
    assert over == before


def status_bar(picture: str) -> bytes:
    """Pixels of the left end of the status bar: the banner of what was reported stands further right."""
    with Image.open(OUT / "pictures" / f"{picture}.png") as image:
        return image.crop((0, image.height - 24, 150, image.height)).tobytes()


def test_a_job_ends_with_its_window_alone_and_by_esc_in_any(report: dict[str, Any]) -> None:
    assert report["goes_on"]
    escaped, beside, closed = report["messages"][5:8]
    stopped = re.compile(rf"Run All stopped: \d of {N_CLIPS} clips are baked, and Run All goes on from there")
    assert stopped.fullmatch(escaped)
    assert beside.startswith("Done: ")
    assert report["baked_beside"] == N_CLIPS
    assert stopped.fullmatch(closed)


def test_w2w_disabled_during_a_job_works_when_it_is_enabled_again(report: dict[str, Any]) -> None:
    assert not report["stuck"]
    assert report["messages"][8].startswith("Done: ")
    assert report["baked_again"] == N_CLIPS


def test_the_collection_of_a_body_can_be_unlinked_and_linked_again(report: dict[str, Any]) -> None:
    assert len(set(report["objects_by_unlink_link"])) == 1
    assert report["works_again"]


def test_labels_edited_between_two_imports_are_those_of_the_file(report: dict[str, Any]) -> None:
    assert report["labels"] == [["strolling"] * 2, ["marching"] * 3]


def test_another_file_can_be_opened_while_a_job_runs(report: dict[str, Any]) -> None:
    assert report["ran_when_opened"]
    assert report["after_opening"] == [False, False]
