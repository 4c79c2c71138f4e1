# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that kills its process costs the pictures, and nothing else."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from headless.commands.study_rehab import FIGURE, draw_figure
from headless.reports.draw import draw_alone
from w2w.core.selection.subsets import Subset

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.skipif(sys.platform != "linux", reason="spoils a library as Linux finds it")
def test_blender_aborts_while_it_renders(tmp_path, motions):
    out = tmp_path / "out"
    spoiled = tmp_path / "libraries"
    spoiled.mkdir()
    (spoiled / "libEGL.so.1").write_text("no library")
    done = subprocess.run(
        [sys.executable, "-m", "headless", "run", motions, "--out", out, "--patches", "8", "--workers", "1"],
        cwd=ROOT,
        env={**os.environ, "LD_LIBRARY_PATH": str(spoiled), "COLUMNS": "400"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "No heatmaps: Blender crashed; its last words:" in done.stdout
    assert "libEGL.so.1" in done.stdout
    assert "Heatmaps:" not in done.stdout
    assert not list((out / "heatmaps").iterdir())
    assert json.loads((out / "summary.json").read_text())["clips"]["used"] == 8
    assert all((out / name).is_file() for name in ("utility.csv", "report.html", "study.blend"))
    status = subprocess.run(
        [sys.executable, "-m", "headless", "status", out],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "Finished after" in status.stdout
    assert "no heatmaps: Blender crashed" in " ".join(status.stdout.split())


def test_the_figure_of_a_finished_study_is_drawn_by_a_worker(drawn_results):
    subset = Subset((3, 7), (0.8, 0.9), 0.85, True, 0.95, 2.0)
    assert draw_alone(draw_figure, drawn_results, subset) == ""
    assert (drawn_results / FIGURE).read_bytes().startswith(b"\x89PNG")


def test_what_cannot_be_drawn_says_why(tmp_path):
    assert "is not the results folder of a finished run" in draw_alone(draw_figure, tmp_path, None)
