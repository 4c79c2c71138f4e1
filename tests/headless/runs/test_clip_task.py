# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip is worked on again when anything its result depends on has changed."""

from dataclasses import replace

import pytest

from w2w.core.motion.library import Clip
from w2w.core.study import StudyConfig
from w2w.headless.runs.clip_task import ClipTask


@pytest.mark.parametrize("changed", [{"activity": "run"}, {"subject": "bo"}, {"name": "b"}])
def test_another_label_is_another_key(tmp_path, changed):
    clip = Clip(tmp_path / "a.bvh", "a.bvh", name="a", activity="walk", subject="al")
    task = ClipTask(clip, tmp_path, StudyConfig(), "inputs")
    assert replace(task, clip=replace(clip, **changed)).key("0") != task.key("0") == replace(task).key("0")
    assert task.key("1") != task.key("0")
