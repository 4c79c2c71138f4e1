# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders of known libraries become one library with labels, which can be written and read again."""

import pytest

from w2w.core.library.library import LibraryError, read_library
from w2w_studies.comparisons.library import labelled_by_name, with_enough, write_labels


def fill(folder, *files):
    for file in files:
        path = folder / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
    return folder


@pytest.fixture
def folders(tmp_path):
    return [
        fill(tmp_path / "one" / "bvh", "jog/bd_jog_001.bvh", "dataset-1_run_active_001.bvh", "kick.bvh"),
        fill(tmp_path / "two" / "bvh", "Walking.fbx", "06_01.bvh"),
    ]


def test_clips_of_several_folders_get_one_set_of_labels(folders):
    found = labelled_by_name(folders)
    assert {(clip.file, clip.activity, clip.subject, clip.source) for clip in found.clips} == {
        ("bvh-1/jog/bd_jog_001.bvh", "run", "HDM05 bd", "HDM05"),
        ("bvh-1/dataset-1_run_active_001.bvh", "run", "Bandai-Namco active", "Bandai-Namco"),
        ("bvh-2/Walking.fbx", "walk", "", "Mixamo"),
        ("bvh-2/06_01.bvh", "walk", "CMU 06", "CMU"),
    }
    assert len({clip.name for clip in found.clips}) == 4
    assert all(clip.path.is_file() for clip in found.clips)
    assert found.skipped == (("bvh-1/kick.bvh", "no known library calls a clip so (docs/studies.md)"),)


def test_written_labels_read_back(folders, tmp_path):
    found = labelled_by_name(folders[:1])
    write_labels(tmp_path / "labels.csv", found)
    again = read_library(folders[0], tmp_path / "labels.csv")
    assert [(c.file, c.activity, c.subject, c.source) for c in again.clips] == [
        (c.file, c.activity, c.subject, c.source) for c in found.clips
    ]


def test_unknown_names_are_refused_with_what_to_do(tmp_path):
    with pytest.raises(LibraryError, match="a known library gives its clips: give --labels"):
        labelled_by_name([fill(tmp_path / "mine", "walk.bvh")])


def test_activities_with_few_clips_are_left_out_and_said(folders):
    found = with_enough(labelled_by_name(folders), 2)
    assert found.activities == {"run": 2, "walk": 2}
    (folders[1] / "Crawling.fbx").write_bytes(b"")
    found = with_enough(labelled_by_name(folders), 2)
    assert found.activities == {"run": 2, "walk": 2}
    assert ("bvh-2/Crawling.fbx", "fewer than 2 clips show crawl (--fewest)") in found.skipped
    with pytest.raises(LibraryError, match="fewer than two activities have 3 clips"):
        with_enough(found, 3)
