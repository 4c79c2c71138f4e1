# SPDX-License-Identifier: GPL-3.0-or-later
"""A body that is removed in the middle of a job costs the job and nothing else."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from w2w.core.motion.import_plan import plan_folder
from w2w.ui import jobs
from w2w.ui.baking import bake_steps, rank_steps
from w2w.ui.motion_import import import_steps, wanted
from w2w.ui.on_body import GONE
from w2w.ui.step3_patches import place_steps

from .made_study import make_study
from .test_upkeep import delete, remove

pytestmark = pytest.mark.usefixtures("blender")

JOBS = {
    "bake": (lambda body, _library: bake_steps(body, range(9)), 4),
    "bake by frame": (lambda body, _library: bake_steps(body, range(9)), 6),
    "rank": (lambda body, _library: rank_steps(body), 2),
    "place": (lambda body, _library: place_steps(body), 1),  # its thread may be done by the first look
    "import": (lambda body, library: import_steps(body, wanted(plan_folder(library))), 4),
}


@pytest.mark.parametrize("how", [delete, remove])
@pytest.mark.parametrize("name", list(JOBS))
def test_a_body_removed_in_the_middle_ends_the_job_with_a_sentence(
    library: Path, name: str, how: object
) -> None:
    make, count = JOBS[name]
    body = make_study(library, "motions patches signals" if name == "rank" else "motions patches")
    if name == "bake by frame":
        body.shape_key_add(name="Basis")  # only Blender's evaluated mesh tells then where patches are
        bpy.context.scene.frame_set(17)
    steps = make(body, library)
    for _ in range(count):
        next(steps)
    how(body)
    operator = type("Operator", (), {"report": lambda *_: None})()
    assert jobs.run_now(operator, "Job", steps) == {"CANCELLED"}
    assert jobs.message == jobs.Message(GONE, True, "Job")
    assert jobs.running is None
    if name == "bake by frame":
        assert bpy.context.scene.frame_current == 17
    assert make_study(library, "patches")
