# SPDX-License-Identifier: GPL-3.0-or-later
"""A body that is removed or edited in the middle of a job costs the job and nothing else."""

from __future__ import annotations

import time
from pathlib import Path

import bpy
import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

from w2w.core import threads
from w2w.core.library.import_plan import plan_folder
from w2w.ui.jobs import jobs
from w2w.ui.jobs.jobs import EDITED, GONE
from w2w.ui.steps.baking import bake_steps, rank_steps
from w2w.ui.steps.motion_import import import_items, import_steps
from w2w.ui.steps.patches import place_steps

from .made_study import make_study
from .test_upkeep import delete, edit_mode, remove

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

JOBS = {
    "bake": (lambda body, _library: bake_steps(body, range(9)), 4),
    "bake by frame": (lambda body, _library: bake_steps(body, range(9)), 6),
    "rank": (lambda body, _library: rank_steps(body), 2),
    "place": (lambda body, _library: place_steps(body), 1),  # its thread may be done by the first look
    "import": (lambda body, library: import_steps(body, import_items(plan_folder(library))), 4),
}


def edit(mesh: bpy.types.Object) -> None:
    """Put the body into Edit Mode."""
    edit_mode(mesh, True)


def edit_bones(mesh: bpy.types.Object) -> None:
    """Put the body's armature into Edit Mode."""
    mesh.parent.hide_set(False)
    edit_mode(mesh.parent, True)


def begun(library: Path, name: str) -> tuple[bpy.types.Object, jobs.Steps]:
    """A body and a job on it, some steps on."""
    make, count = JOBS[name]
    body = make_study(library, "motions patches signals" if name == "rank" else "motions patches")
    if name == "bake by frame":
        body.shape_key_add(name="Basis")  # only Blender's evaluated mesh tells then where patches are
        bpy.context.scene.frame_set(17)
    steps, clips = make(body, library), len(body.w2w.clips)
    for _ in range(count):
        next(steps)
    while name == "import" and len(body.w2w.clips) == clips:
        next(steps)
    return body, steps


def ended_with(steps: jobs.Steps, sentence: str) -> None:
    """Go on with a job and see it end."""
    operator = type("Operator", (), {"report": lambda *_: None})()
    assert jobs.run_now(operator, "Job", steps) == {"CANCELLED"}
    assert jobs.message == jobs.Message(sentence, True, "Job")
    assert jobs.running is None


@pytest.mark.parametrize(
    ("name", "how"),
    [*((name, delete) for name in ("import", "bake by frame", "rank")), ("bake", remove)]
    + [pytest.param(name, delete, marks=pytest.mark.slow) for name in ("place", "bake")],
)
def test_a_body_removed_in_the_middle_ends_the_job_with_a_sentence(
    library: Path, name: str, how: object
) -> None:
    body, steps = begun(library, name)
    how(body)
    ended_with(steps, GONE)
    if name == "bake by frame":
        assert bpy.context.scene.frame_current == 17
    assert make_study(library, "patches")


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("import", edit),
        *(pytest.param(name, edit, marks=pytest.mark.slow) for name in JOBS if name != "import"),
    ]
    + [("bake", edit_bones)],
)
def test_a_body_put_into_edit_mode_ends_the_job_with_a_sentence(
    library: Path, name: str, how: object
) -> None:
    body, steps = begun(library, name)
    clips = len(body.w2w.clips)
    how(body)
    ended_with(steps, EDITED)
    bpy.ops.object.mode_set(mode="OBJECT")
    if name == "import":
        assert len(body.w2w.clips) < clips  # what had come in is taken back
    if name == "bake by frame":
        assert bpy.context.scene.frame_current == 17
    assert bpy.ops.w2w.place_patches() == {"FINISHED"}


def test_matrix_products_of_a_job_take_one_thread(library: Path) -> None:
    seen: list[set[int]] = []
    while threads._limits:  # of a ranking that was ended, and may take a second until it sees so
        time.sleep(0.01)

    def look() -> None:
        libraries = ThreadpoolController().select(user_api="blas").info()
        seen.append({library["num_threads"] for library in libraries})

    @jobs.on_body
    def steps(_mesh: bpy.types.Object) -> jobs.Steps:
        look()
        yield jobs.Step(0.0, "")
        look()
        return ""

    with threadpool_limits(2, user_api="blas"):
        for _ in steps(make_study(library, "")):
            look()
        look()
    assert seen == [{1}, {1}, {1}, {2}]
