# SPDX-License-Identifier: GPL-3.0-or-later
"""Folds never share a group, every testable activity is trained, one motion is one group."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from w2w.core.ranking.folds import check_testable, deal, grouped_folds, subject_folds, untestable


@st.composite
def libraries(draw):
    """Windows of clips of activities: (activity, clip), each activity of 2 to 6 clips."""
    activity, clip = [], []
    for label in range(draw(st.integers(1, 8))):
        for number in range(draw(st.integers(2, 6))):
            n_windows = draw(st.integers(1, 9))
            activity += [f"a{label}"] * n_windows
            clip += [f"a{label}/{number}"] * n_windows
    return np.array(activity), np.array(clip)


@pytest.mark.later
@settings(max_examples=60, deadline=None)
@given(library=libraries(), folds=st.integers(2, 6), seed=st.integers(0, 5))
def test_no_clip_is_split_and_no_activity_is_tested_untrained(library, folds, seed):
    activity, clip = library
    fold = grouped_folds(activity, clip, folds, seed)
    assert fold.min() >= 0
    assert fold.max() < folds
    for name in np.unique(clip):
        assert len(np.unique(fold[clip == name])) == 1
    for name in np.unique(activity):
        n_clips = len(np.unique(clip[activity == name]))
        assert len(np.unique(fold[activity == name])) == min(folds, n_clips)
    assert untestable(activity, clip, sorted(set(activity)), fold) == {}


def test_folds_are_even_and_seeded():
    activity = np.repeat([f"a{k}" for k in range(6)], 50)
    clip = np.repeat(np.arange(60), 5)
    fold = grouped_folds(activity, clip, 5, seed=1)
    for name in np.unique(activity):
        assert np.bincount(fold[activity == name], minlength=5).tolist() == [10] * 5
    np.testing.assert_array_equal(fold, grouped_folds(activity, clip, 5, seed=1))
    assert (fold != grouped_folds(activity, clip, 5, seed=2)).any()


@pytest.mark.parametrize("seed", range(3))
def test_a_long_clip_counts_as_much_as_the_short_ones_that_have_as_many_windows(seed):
    clip = np.repeat(np.arange(5), [8, 2, 2, 2, 2])
    fold = grouped_folds(np.full(len(clip), "walk"), clip, 2, seed)
    assert np.bincount(fold).tolist() == [8, 8]


@pytest.mark.parametrize("seed", range(3))
def test_long_clips_of_several_activities_are_spread(seed):
    """Each activity has a long clip and a short one, in different folds: the longest meets two short ones."""
    windows = [20, 1, 10, 1, 10, 1]
    clip = np.repeat(np.arange(6), windows)
    fold = grouped_folds(np.array(["a", "b", "c"])[clip // 2], clip, 2, seed)
    assert sorted(np.bincount(fold)) == [1 + 10 + 10, 20 + 1 + 1]


def test_the_protocol_names_as_many_folds_as_there_are():
    activity, clip = np.repeat(["sit", "walk"], 8), np.repeat(np.arange(4), 4)
    fold, tested, left_out, protocol = deal(activity, clip, None, ["sit", "walk"], 5, 0)
    assert protocol == f"{len(np.unique(fold))}-fold cross-validation grouped by clip"
    assert (tested, left_out) == (("sit", "walk"), {})


def test_an_activity_of_one_subject_is_not_tested_where_that_subject_is_left_out():
    activity = np.array(["bow", "bow", "sit", "sit", "walk", "walk"])
    subject = np.array(["ann", "ann", "ann", "bob", "ann", "bob"])
    _, tested, left_out, _ = deal(activity, np.arange(6), subject, ["bow", "sit", "walk"], 5, 0)
    assert tested == ("sit", "walk")
    assert left_out.keys() == {"bow"}


def test_subjects_are_folds():
    subject = np.array(["b", "a", "b", "c"])
    np.testing.assert_array_equal(subject_folds(subject, np.arange(4)), [1, 0, 1, 2])
    with pytest.raises(ValueError, match="1 of 3 have none"):
        subject_folds(np.array(["a", "", "b"]), np.arange(3))
    with pytest.raises(ValueError, match="needs two subjects, and all clips are of a"):
        subject_folds(np.array(["a", "a"]), np.arange(2))


def test_a_person_of_several_spellings_is_left_out_at_once():
    subject = np.array(["Anna", "bob", "ANNA", " anna", "Bob"])
    fold = subject_folds(subject, np.arange(5))
    assert (fold == [0, 1, 0, 0, 1]).all()
    activity = np.array(["walk", "walk", "run", "walk", "run"])
    assert deal(activity, np.arange(5), subject, ["run", "walk"], 5, 0)[3] == "leave one of 2 subjects out"


def test_left_out_activities_have_a_true_sentence():
    activity = np.array(["walk", "walk", "bow", "bow", "jump", "jump"])
    clip = np.array(["w1", "w2", "b1", "b1", "j1", "j2"])
    reasons = untestable(activity, clip, ["walk", "bow", "fly", "jump"], np.array([0, 1, 0, 0, 1, 1]))
    assert set(reasons) == {"bow", "fly", "jump"}
    assert "bow has only one clip" in reasons["bow"]
    assert "fly has no clip" in reasons["fly"]
    assert "jump fell into one fold" in reasons["jump"]


def test_a_motion_of_two_subjects_is_never_trained_on_when_its_copy_is_tested():
    subject = np.array(["b", "a", "b", "c", "a", "c"])
    motion = np.array(["x", "y", "z", "x", "u", "v"])
    fold = subject_folds(subject, motion)
    np.testing.assert_array_equal(fold, [1, 0, 1, 1, 0, 2])
    for one in np.unique(fold):
        assert not set(motion[fold == one]) & set(motion[fold != one])
    with pytest.raises(ValueError, match="all motions are of a"):
        subject_folds(np.array(["a", "b"]), np.array(["x", "x"]))


def test_clips_that_no_subject_can_be_left_out_of_are_refused_before_work():
    activities, clips = ["walk", "walk", "run", "run"], list("abcd")
    check_testable(activities, clips, ["x", "y", "x", "y"])
    for subjects, reason in (
        (["", "", "", ""], "4 of 4 have none"),
        (["x", "y", "", "y"], "1 of 4 have none"),
        (["x", "x", "x", "x"], "all clips are of x"),
        (["x", "y", "x", "x"], "only walk|there is none"),
    ):
        with pytest.raises(ValueError, match=reason):
            check_testable(activities, clips, subjects)
    check_testable(activities, clips)  # none is needed where no subject is left out
