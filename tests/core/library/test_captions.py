# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips labelled by the words of their captions, in HumanML3D's format."""

import numpy as np
import pytest

from w2w.core.library.labels import LibraryError
from w2w.core.library.library import read_library

CAPTIONS = {
    "000000": ["a man kicks something with his left leg.#a/DET man/NOUN kick/VERB something/PRON#0.0#0.0"],
    "000001": [
        "he walks in a circle.#he/PRON walk/VERB in/ADP a/DET circle/NOUN#0.0#0.0",
        "he jumps once.#he/PRON jump/VERB once/ADV#1.5#2.5",
    ],
    "000002": ["a person runs, then walks.#a/DET person/NOUN run/VERB then/ADV walk/VERB#0.0#0.0"],
    "000003": ["someone throws a ball.#someone/PRON throw/VERB a/DET ball/NOUN#0.0#0.0"],
    "M000001": ["SHE IS WALKING#she/PRON be/AUX walk/VERB#0.0#0.0"],
}


@pytest.fixture
def humanml(tmp_path):
    for name in ("new_joints", "texts"):
        (tmp_path / name).mkdir()
    for name, lines in CAPTIONS.items():
        np.save(tmp_path / "new_joints" / f"{name}.npy", np.zeros((4, 22, 3)))
        (tmp_path / "texts" / f"{name}.txt").write_text("\n".join(lines), encoding="utf-8")
    np.save(tmp_path / "new_joints" / "000004.npy", np.zeros((4, 22, 3)))
    return tmp_path


def labelled(folder, *rows):
    (folder / "words.csv").write_text("\n".join(["caption,activity", *rows]), encoding="utf-8")
    return read_library(folder / "new_joints", folder / "words.csv")


def test_words_in_any_form_label_a_clip_and_only_one_activity_may(humanml):
    found = labelled(humanml, "walk,walking", "Kick,kicking", "runs,running", "jump,jumping")
    assert {clip.file: clip.activity for clip in found.clips} == {
        "000000.npy": "kicking",
        "000001.npy": "walking",  # it jumps in a part of it only
        "M000001.npy": "walking",
    }
    assert dict(found.skipped) == {
        "000002.npy": "its captions are of running and walking",
        "000003.npy": "none of its captions is listed",
        "000004.npy": "it has no captions",
    }
    assert found.check.not_listed == ("000002.npy", "000003.npy", "000004.npy")


def test_several_words_must_stand_side_by_side(humanml):
    found = labelled(humanml, "in a circle,circling", "throw ball,throwing", "all,x")
    assert {clip.file: clip.activity for clip in found.clips} == {"000001.npy": "circling"}


def test_captions_may_lie_beside_the_clips(humanml):
    for text in (humanml / "texts").iterdir():
        text.rename(humanml / "new_joints" / text.name)
    assert len(labelled(humanml, "throw,throwing").clips) == 1


def test_words_that_label_nothing_are_refused(humanml):
    with pytest.raises(LibraryError, match=r"holds the words of no caption of the 6 motion files"):
        labelled(humanml, "swim,swimming")


def test_a_csv_of_files_may_have_a_column_of_captions(humanml):
    (humanml / "labels.csv").write_text("file,activity,caption\n000000.npy,kick,a man kicks\n")
    found = read_library(humanml / "new_joints", humanml / "labels.csv")
    assert [clip.activity for clip in found.clips] == ["kick"]
