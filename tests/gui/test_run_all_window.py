# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All in a real Blender window: Esc keeps what is baked; a clicked spot is named and ranked.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from .test_window import PROJECT, SANDBOX, TIMEOUT_S

OUT = PROJECT / ".cache" / "gui_run_all"
ACTIVITIES = ("bow", "run", "walk-left")
N_CLIPS = 9

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(shared_data: Path) -> dict[str, Any]:
    """What the window showed."""
    if not (SANDBOX / ".ready").exists():
        pytest.skip("no real Blender here: run tools/real_blender.sh first")
    zips = sorted((PROJECT / "dist").glob("w2w-*-linux-x64.zip"), key=lambda path: path.stat().st_mtime)
    if not zips:
        pytest.skip("no extension here: run 'make extension' first")
    shutil.rmtree(OUT, ignore_errors=True)
    for activity in ACTIVITIES:
        (OUT / "clips" / activity).mkdir(parents=True)
        for file in sorted((shared_data / "bvh/bandai_namco").glob(f"dataset-1_{activity}_*.bvh")):
            shutil.copy(file, OUT / "clips" / activity)
    inside = f"/project/{OUT.relative_to(PROJECT)}"
    variables = {
        "W2W_ZIP": f"/project/dist/{zips[-1].name}",
        "W2W_CLIPS": f"{inside}/clips",
        "W2W_OUT": inside,
    }
    blender = [
        "blender", "--factory-startup", "--enable-event-simulate",
        "--window-geometry", "0", "0", "1600", "1000", "--python", "/project/tests/gui/run_all.py",
    ]  # fmt: skip
    done = subprocess.run(
        [
            PROJECT / "tools" / "real_blender.sh", "run", *(f"{k}={v}" for k, v in variables.items()),
            "xvfb-run", "-a", "-s", "-screen 0 1600x1000x24", *blender,
        ],
        env={**os.environ, "W2W_BLENDER_SANDBOX": str(SANDBOX)},
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )  # fmt: skip
    (OUT / "blender.log").write_text(done.stdout + done.stderr)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return json.loads((OUT / "report.json").read_text())


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
    assert 1 <= scores["rank"] <= scores["of"] == 129
    assert scores["loss"] >= 0
