# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip as every door opens it: its labels, its own frame rate, and Blender's reader, which is handed in."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.keypoints.facts import PoseFacts
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.source import UnusableMotion
from w2w.core.reading.clips import Clip, How, open_clip, read_clip

HOW = How(pose=PoseFacts(rate=60.0))


@pytest.fixture
def clip(tmp_path):
    motion = next(iter(demo_motions(1).values())).labelled("from the file", "Ada", "own")
    motion.save(tmp_path / "a.npz")
    return Clip(tmp_path / "a.npz", "a.npz", "", "")


def test_a_clip_without_a_name_keeps_the_labels_of_its_file(clip, bundled_body):
    own = open_clip(clip, bundled_body, HOW).motion
    given = open_clip(replace(clip, name="b", activity="walking", subject="Bo"), bundled_body, HOW).motion
    assert (own.activity, own.subject, own.clip) == ("from the file", "Ada", "own")
    assert (given.activity, given.subject, given.clip) == ("walking", "Bo", "b")


def test_its_own_rate_goes_before_that_of_all(clip, bundled_body):
    assert open_clip(clip, bundled_body, HOW).facts()["frame_rate"] == 60.0
    assert open_clip(replace(clip, rate=50.0), bundled_body, HOW).facts()["frame_rate"] == 50.0


def test_who_hangs_is_told_unless_the_axis_was_given(clip, bundled_body):
    motion = read_clip(clip, HOW)
    turn = np.diag([1.0, -1.0, -1.0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = turn @ rotations[:, 0]
    replace(motion, rotations=rotations, pelvis=motion.pelvis @ turn + [0, 0, 2.0]).save(clip.path)
    assert open_clip(clip, bundled_body, HOW).facts()["head_down"]
    assert "head_down" not in open_clip(clip, bundled_body, How(pose=PoseFacts(up="z"))).facts()


def test_blenders_reader_reads_what_it_is_handed(clip, bundled_body):
    asked = []

    def read(path, pose, _ups, animation):
        asked.append((path.name, pose.rate, animation))
        return read_clip(clip, HOW)

    fbx = replace(clip, path=clip.path.with_suffix(".fbx"), rate=25.0, animation="Walk")
    assert open_clip(fbx, bundled_body, replace(HOW, blender=read)).motion.n_frames
    assert asked == [("a.fbx", 25.0, "Walk")]
    with pytest.raises(UnusableMotion, match="Blender reads it"):
        open_clip(fbx, bundled_body, HOW)
