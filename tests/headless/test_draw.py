# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that kills its process costs the pictures, and nothing else."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


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
