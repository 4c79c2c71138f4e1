# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips with labels and their windows become a map, and each clip learns which one shows its motion first."""

from pathlib import Path

import numpy as np
import pytest

from w2w.core.findings.cautions import subjects_sentence
from w2w.core.library.library import Clip
from w2w.core.motion.signature import WIDTH
from w2w.core.ranking.pooling import Pooling
from w2w.core.study.clip_files import ClipWindows, features_file, write_features
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip, WindowLabels, known_motions, rank_clips, same_motions

ACTIVITIES = ("walk", "run", "jump")


def drawn(n_clips=12, n_windows=4):
    """Windows of clips of three activities that features tell apart, and a signature of its own for each."""
    rng = np.random.default_rng(0)
    clips, windows, features = [], [], []
    for number in range(n_clips):
        activity = ACTIVITIES[number % len(ACTIVITIES)]
        clips.append(Clip(Path(f"{number}.bvh"), f"{number}.bvh", f"clip_{number}", activity))
        windows.append(ClipWindows(np.ones(n_windows, bool), rng.normal(size=5 * WIDTH)))
        part = rng.normal(size=(n_windows, 2, 3)).astype(np.float32)
        part[..., number % len(ACTIVITIES)] += 4
        features.append(part)
    return clips, windows, np.concatenate(features)


def test_files_of_a_library_are_ranked_as_they_are():
    clips, windows, features = drawn()
    ranked = same_motions(clips, windows)
    utility = rank_clips(ranked, windows, features, StudyConfig(folds=2), Pooling.none(2))
    assert utility.activities == tuple(sorted(ACTIVITIES))
    assert [(clip.name, clip.activity) for clip in ranked] == [(clip.name, clip.activity) for clip in clips]
    assert [clip.motion_key for clip in ranked] == [clip.name for clip in clips]


def test_a_second_file_of_a_motion_names_the_first_by_its_signature_or_by_its_key():
    clips, windows, features = drawn()
    windows[3] = ClipWindows(windows[3].is_test, windows[0].signature)
    clips = [LabelledClip(clip.name, clip.activity) for clip in clips]
    clips[4] = LabelledClip("clip_4", "run", "", "take 7")
    clips[7] = LabelledClip("clip_7", "run", "", "take 7")
    ranked = same_motions(clips, windows)
    shown = {clip.name: clip.motion_key for clip in ranked if clip.motion_key != clip.name}
    assert shown == {"clip_3": "clip_0", "clip_7": "clip_4"}
    labels = WindowLabels.of(ranked, windows)
    assert labels.motion.tolist().count("clip_0") == 8
    assert len(labels.is_test) == len(features)


def test_a_clips_windows_are_read_back_and_cannot_be_changed(tmp_path):
    path = features_file(tmp_path, "a")
    path.parent.mkdir(parents=True)
    signature = np.arange(4.0)
    write_features(path, np.zeros((3, 2, 1), np.float32), np.array([True, False, True]), signature)
    found = ClipWindows.read(tmp_path, "a")
    assert found.is_test.tolist() == [True, False, True]
    assert found.signature.tolist() == signature.tolist()
    with pytest.raises(AttributeError):
        found.is_test = None


def test_a_motion_of_two_subjects_is_known_by_its_file_or_its_key_before_it_is_read(tmp_path):
    clips = []
    for number, (content, subject, key) in enumerate(
        [("a", "Anna", ""), ("a", "Ben", ""), ("b", "Anna", "k"), ("c", "Cleo", "k"), ("d", "Dan", "")]
    ):
        path = tmp_path / f"{number}.bvh"
        path.write_text(content)
        clips.append(Clip(path, path.name, path.stem, "walk", subject, key))
    known = known_motions(clips)
    assert [clip.motion_key for clip in known] == ["0", "0", "2", "2", "4"]
    assert subjects_sentence(known).startswith("4 clips of Anna, Ben and Cleo show the same motion")
    assert subjects_sentence(known_motions(clips[1:3])) == ""
