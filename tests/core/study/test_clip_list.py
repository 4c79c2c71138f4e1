# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of clips comes back as it was written, whatever files are called, and damage is said."""

import pytest

from w2w.core.study.clip_files import CLIP_LIST, is_used, read_clip_list, write_clip_list

CLIPS = [
    {
        "file": "walk/é 日.fbx",
        "clip": "walk_1",
        "activity": 'say "hi"',
        "subject": "",
        "windows": 3,
        "scale": 0.5,
    },
    {"file": "a\\nb.bvh", "skipped": "the file is empty (0 bytes)"},
]


def test_clips_come_back(tmp_path):
    write_clip_list(tmp_path, iter(CLIPS))
    assert list(read_clip_list(tmp_path)) == CLIPS
    assert [is_used(entry) for entry in CLIPS] == [True, False]


@pytest.mark.parametrize("text", ["{", "[]\n", '{"clip": "a"}\n'])
def test_a_damaged_list_is_an_error(tmp_path, text):
    (tmp_path / CLIP_LIST).write_text(text)
    with pytest.raises(ValueError, match=r"damaged|Expecting"):
        list(read_clip_list(tmp_path))
