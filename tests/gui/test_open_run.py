# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run left opens in a real Blender window: its file, and its folder dropped on another scene.

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

from ..made_run import make_run
from .test_window import PROJECT, SANDBOX, TIMEOUT_S

OUT = PROJECT / ".cache" / "gui_run"
N_PATCHES = 512
PICTURES = ("1_opened", "2_ranking", "3_signals", "4_choosing", "5_dropped")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(shared_data: Path) -> Path:
    """The results folder of a run with as many patches as people take."""
    if not (SANDBOX / ".ready").exists():
        pytest.skip("no real Blender here: run tools/real_blender.sh first")
    if not sorted((PROJECT / "dist").glob("w2w-*-linux-x64.zip")):
        pytest.skip("no extension here: run 'make extension' first")
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    return make_run(shared_data, OUT, N_PATCHES)


@pytest.fixture(scope="module")
def report(results: Path) -> dict[str, Any]:
    """What the window showed."""
    zips = sorted((PROJECT / "dist").glob("w2w-*-linux-x64.zip"), key=lambda path: path.stat().st_mtime)
    variables = {
        "W2W_ZIP": f"/project/dist/{zips[-1].name}",
        "W2W_RUN": f"/project/{results.relative_to(PROJECT)}",
        "W2W_OUT": f"/project/{OUT.relative_to(PROJECT)}",
    }
    blender = [
        "blender", "--factory-startup", "--enable-event-simulate",
        "--window-geometry", "0", "0", "1600", "1000", "--python", "/project/tests/gui/open_run.py",
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


@pytest.mark.parametrize("way", ["enabled_late", "opened", "dropped"])
def test_the_panel_shows_the_run(report: dict[str, Any], results: Path, way: str) -> None:
    places = json.loads((results / "summary.json").read_text())["subset"]["places"]
    found = report[way]
    assert found["message"] == f"Opened a finished run: 9 clips on {N_PATCHES} patches"
    assert (found["clips"], found["baked"], found["patches"]) == (9, 9, N_PATCHES)
    assert found["keys"] > 20
    assert found["chosen"] == [place["patch"] for place in places]
    assert found["regions"] == 8
    assert found["heatmaps"] == 4
    assert found["up_to_date"]


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


def test_a_deleted_body_takes_its_patches_along_and_undo_brings_them_back(report: dict[str, Any]) -> None:
    there, gone = N_PATCHES + 2, 1  # the body and its armature
    assert report["objects_by_delete_undo_redo"] == [there, gone, there, gone]


@pytest.mark.usefixtures("report")
def test_every_step_has_its_picture() -> None:
    assert set(PICTURES) <= {path.stem for path in (OUT / "pictures").glob("*.png")}
