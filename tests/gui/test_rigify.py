# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig that Rigify makes, in the Blender that brings Rigify along: Use Character knows its bones.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import json
import shutil
import subprocess

import pytest

from .sandbox import PROJECT, RESULTS, TIMEOUT_S, inside, newest_zip

OUT = RESULTS / "rigify"

pytestmark = pytest.mark.slow


def test_a_character_on_a_generated_rig_finds_itself_on_our_body() -> None:
    extension = newest_zip()
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    done = subprocess.run(
        [
            PROJECT / "tools" / "real_blender.sh", "run", f"W2W_ZIP={inside(extension)}",
            f"W2W_OUT={inside(OUT)}", "blender", "--background", "--factory-startup",
            "--python-exit-code", "1", "--python", "/project/tests/gui/rigify_character.py",
        ],
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    report = json.loads((OUT / "report.json").read_text())
    if not report["rigify"]:
        pytest.skip("this Blender comes without Rigify")
    assert (report["map"], report["joints"], report["deforming"]) == ("Rigify", 24, True)
    assert report["bones"] > 300  # controls and mechanisms beside those that deform
    assert report["twists"] == 8
    assert report["meshes"] == ["Skin"]
    assert report["from_itself"] < 0.03
