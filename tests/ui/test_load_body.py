# SPDX-License-Identifier: GPL-3.0-or-later
"""An SMPL body of one's own is read in the background: the window waits for nothing, Esc leaves nothing."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from w2w.core.body.body import Body
from w2w.ui.jobs import jobs
from w2w.ui.steps.body import load_steps

from .made_study import names_in_file

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def saved(bundled_body: Body, tmp_path: Path) -> Path:
    """A body in a file."""
    bundled_body.save(tmp_path / "mine.npz")
    return tmp_path / "mine.npz"


def test_the_body_is_read_in_a_thread_and_added(saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    threads = []
    in_thread = jobs.in_thread
    monkeypatch.setattr(jobs, "in_thread", lambda *given: threads.append(given[1]) or in_thread(*given))
    assert bpy.ops.w2w.load_body(filepath=str(saved)) == {"FINISHED"}
    assert threads == ["reading mine.npz", "building the body"]
    assert len(bpy.context.scene.w2w.body.data.vertices) == 6890
    assert (jobs.message.text, jobs.message.job) == ("Loaded mine.npz", "Load SMPL Body")


def test_esc_leaves_the_scene_as_it_was(saved: Path) -> None:
    before = names_in_file()
    steps = load_steps(saved)
    next(steps)
    steps.close()
    assert names_in_file() == before
    assert bpy.context.scene.w2w.body is None


def test_a_file_that_is_no_body_says_why(tmp_path: Path) -> None:
    (tmp_path / "cube.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(RuntimeError, match=r"cube\.obj"):
        bpy.ops.w2w.load_body(filepath=str(tmp_path / "cube.obj"))
    assert jobs.message.is_error
    assert bpy.context.scene.w2w.body is None
