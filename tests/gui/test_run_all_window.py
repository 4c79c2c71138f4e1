# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All in a real Blender window: Esc keeps what is baked; a clicked spot is named and ranked.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from .sandbox import RESULTS, inside, newest_zip, run_in_window

OUT = RESULTS / "run_all"
ACTIVITIES = ("bow", "run", "walk-left")
N_CLIPS = 9

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(shared_data: Path) -> dict[str, Any]:
    """What the window showed."""
    return run_in_window("run_all.py", OUT, {"W2W_CLIPS": inside(copy_clips(shared_data, OUT))})


def copy_clips(shared_data: Path, out: Path) -> Path:
    """Real clips in folders by activity, which a window sees."""
    newest_zip()  # skips before files are copied where the window cannot be tried
    shutil.rmtree(out, ignore_errors=True)
    for activity in ACTIVITIES:
        (out / "clips" / activity).mkdir(parents=True)
        for file in sorted((shared_data / "bvh/bandai_namco").glob(f"dataset-1_{activity}_*.bvh")):
            shutil.copy(file, out / "clips" / activity)
    return out / "clips"


def test_esc_keeps_the_clips_that_are_baked_and_the_next_press_does_the_rest(report: dict[str, Any]) -> None:
    baked = report["baked_after_esc"]
    assert report["clips"] == N_CLIPS
    assert 3 <= baked < N_CLIPS
    stopped = f"Run All stopped: {baked} of {N_CLIPS} clips are baked, and Run All goes on from there"
    assert report["messages"][1] == stopped
    assert report["kept"] == baked
    assert report["baked"] == N_CLIPS
    assert report["worn"] > 0


def test_one_undo_takes_back_what_the_second_press_did(report: dict[str, Any]) -> None:
    assert report["baked_after_undo"] == report["baked_after_esc"]


def test_a_clicked_spot_gets_a_name_a_rank_and_a_loss(report: dict[str, Any]) -> None:
    (name, vertex), scores = next(iter(report["own"].items())), report["scores"]
    assert name.startswith("my ")
    assert vertex == report["clicked"] == scores["vertex"]
    assert 1 <= scores["rank"] <= scores["of"] == 513
    low, high = scores["costs_interval"]
    assert low <= scores["costs"] <= high
