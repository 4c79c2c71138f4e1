# SPDX-License-Identifier: GPL-3.0-or-later
"""A script that registers the extension and forgets to unregister it ends all the same."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANG_S

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
import w2w as extension
extension.register()
bpy.ops.w2w.add_body()
study = bpy.context.scene.w2w.body.w2w
study.patch_count = 24
bpy.ops.w2w.place_patches()
from w2w.ui.jobs import jobs
from w2w.ui.steps import patches
steps = patches.place_steps(bpy.context.scene.w2w.body)
next(steps)
jobs.running = jobs.Job("Place Patches", steps)
print("the end")
"""


@pytest.mark.slow
def test_leaving_in_the_middle_of_a_job_without_unregistering_ends_cleanly() -> None:
    project = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, project],
        capture_output=True,
        text=True,
        timeout=HANG_S,  # without its own way out Blender's module hangs for ever
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("the end\n"), done.stderr
    assert "the end" in done.stdout
    assert "Not freed memory" not in done.stdout + done.stderr
