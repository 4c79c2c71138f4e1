# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's clips as rows of the panel's list."""

import json

import pytest

from w2w.core.findings.listed import clips_of
from w2w.core.study.clip_files import write_clip_list
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.results import StudyResults

CLIPS = tuple(LabelledClip(name, "walk", "ann") for name in ("one", "two", "three"))
FACTS = {"frames": 30, "frame_rate": 25, "cut": "2 at the end", "windows": 3}


def run_of(out, entries):
    write_clip_list(out, entries)
    return StudyResults(out, None, CLIPS, {}, None)


def test_a_clip_whose_motion_the_file_does_not_hold_says_where_it_is(tmp_path):
    entries = [{"file": f"/else/{clip.name}.bvh"} | FACTS for clip in CLIPS]
    run = run_of(tmp_path, [*entries, {"file": "sub/bad.bvh", "skipped": "it is empty"}])
    first, second, third, bad = clips_of(run, {"one": "run-1"}, {"one": "an action", "two": None})
    assert (first["problem"], first["action"], first["signals"]) == ("", "an action", "run-1")
    assert "no longer where the run left it" in second["problem"]
    assert "Open Results" in third["problem"]
    assert (first["file"], first["n_frames"], first["rate"], first["scale"]) == ("one.bvh", 30, 25.0, 1.0)
    assert json.loads(first["facts"]) == {"cut": "2 at the end"}
    assert bad == {"name": "bad.bvh", "file": "sub/bad.bvh", "problem": "it is empty"}


@pytest.mark.parametrize(
    ("wrong", "said"), [({}, "does not say 'frames'"), ({"frames": "many"}, "is damaged")]
)
def test_a_list_that_does_not_say_what_is_needed_is_named(tmp_path, wrong, said):
    run = run_of(tmp_path, [{"file": "one.bvh"} | wrong] + [{"file": "two.bvh"} | FACTS] * 2)
    with pytest.raises(ValueError, match=said):
        clips_of(run, {}, {})
