# SPDX-License-Identifier: GPL-3.0-or-later
"""A pilot in a real Blender window: added by mouse, saved with the results, shown where they are opened.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from w2w.core.patches.naming import resolve
from w2w.core.study.results import StudyResults

from ..made_run import make_run
from ..phone_exports import worn_like_clips
from .sandbox import RESULTS, inside, newest_zip, run_in_window

OUT = RESULTS / "pilot"

pytestmark = pytest.mark.slow


def test_a_pilot_is_added_saved_and_shown_again(shared_data: Path) -> None:
    newest_zip()  # skips before the run where the window cannot be tried
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    results = make_run(shared_data, OUT, 128)
    study = StudyResults.load(results)
    worn = worn_like_clips(study, OUT / "worn", resolve("left wrist", study.body(), study.patches))
    report = run_in_window("add_pilot.py", OUT, {"W2W_RUN": inside(results), "W2W_WORN": inside(worn)})
    assert report["before"] is None
    found = report["added"]
    assert found["sentence"].startswith("With your pilot (left wrist, 2 people, ")
    saved = json.loads((OUT / "saved" / "summary.json").read_text(encoding="utf-8"))
    assert saved["pilot"] == found
    assert report["opened"] == found
    assert found["sentence"] in report["messages"]
