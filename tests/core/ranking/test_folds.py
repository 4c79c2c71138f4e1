# SPDX-License-Identifier: GPL-3.0-or-later
"""Folds never share a group, every testable activity is trained, one motion is one group."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from w2w.core.ranking.folds import grouped_folds, subject_folds, untestable


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


@settings(max_examples=200, deadline=None)
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


def test_subjects_are_folds():
    subject = np.array(["b", "a", "b", "c"])
    np.testing.assert_array_equal(subject_folds(subject, np.arange(4)), [1, 0, 1, 2])
    with pytest.raises(ValueError, match="clip 'x' belongs to more than one subject"):
        subject_folds(subject, np.array(["x", "y", "z", "x"]))
    with pytest.raises(ValueError, match="some have none"):
        subject_folds(np.array(["a", "", "b"]), np.arange(3))
    with pytest.raises(ValueError, match="at least two subjects"):
        subject_folds(np.array(["a", "a"]), np.arange(2))


def test_left_out_activities_have_a_true_sentence():
    activity = np.array(["walk", "walk", "bow", "bow", "jump", "jump"])
    clip = np.array(["w1", "w2", "b1", "b1", "j1", "j2"])
    reasons = untestable(activity, clip, ["walk", "bow", "fly", "jump"], np.array([0, 1, 0, 0, 1, 1]))
    assert set(reasons) == {"bow", "fly", "jump"}
    assert "bow has only one clip" in reasons["bow"]
    assert "fly has no clip" in reasons["fly"]
    assert "jump fell into one fold" in reasons["jump"]
