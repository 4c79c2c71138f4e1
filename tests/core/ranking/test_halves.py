# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans of trainings and tests: every window tested once by the whole, and halves that share nothing."""

import numpy as np
import pytest

from w2w.core.ranking.halves import deal_halves, plan


def library(n_clips=24, subjects=0):
    clip = np.repeat(np.arange(n_clips), 3)
    labels = clip % 3
    fold = clip // 3 % subjects if subjects else clip // 3 % 4
    return labels, clip, fold, np.arange(len(clip)) % 3 < 2


def trained(work, trial):
    """Windows that any model of a trial was trained on."""
    blocks = np.concatenate([work.splits[split].train for split in trial.splits])
    return np.flatnonzero(np.isin(work.block, blocks))


@pytest.mark.parametrize("subjects", [0, 6])
def test_the_whole_tests_every_window_once_and_never_on_what_it_trained(subjects):
    labels, clip, fold, is_test = library(subjects=subjects)
    work = plan(labels, clip, fold, is_test, by_subject=bool(subjects))
    np.testing.assert_array_equal(np.sort(work.whole.windows), np.flatnonzero(is_test))
    for trial in work.trials:
        for split in (work.splits[number] for number in trial.splits):
            seen = np.isin(work.block, split.train)
            assert seen.any()
            assert not np.isin(fold[split.tested], fold[seen]).any()


@pytest.mark.parametrize("subjects", [0, 6])
def test_halves_share_no_clip_and_no_subject(subjects):
    labels, clip, fold, is_test = library(subjects=subjects)
    work = plan(labels, clip, fold, is_test, by_subject=bool(subjects))
    whose = fold if subjects else clip
    assert len(work.pairs) == (10 if subjects else 4)
    for pair in work.pairs:
        one, other = (np.r_[trained(work, trial), trial.windows] for trial in pair)
        assert not np.isin(whose[one], whose[other]).any()
        if subjects:
            assert [len(np.unique(fold[trial.windows])) for trial in pair] == [3, 3]
        assert pair[0].testable.all()
        assert pair[1].testable.all()


@pytest.mark.parametrize("subjects", [0, 3, 6])
def test_some_windows_are_tested_and_trained_on_as_all_are(subjects):
    labels, clip, fold, is_test = library(subjects=subjects)
    work = plan(labels, clip, fold, is_test, by_subject=bool(subjects))
    rows = np.flatnonzero(np.arange(len(clip)) % 5 > 1)
    some = work.among(rows, labels[rows])
    assert len(some.pairs) == (3 if subjects == 3 else 2)
    before = (work.whole, *(trial for pair in work.pairs for trial in pair))
    after = (some.whole, *(trial for pair in some.pairs for trial in pair))
    for one, other in zip(before, after, strict=False):
        np.testing.assert_array_equal(rows[other.windows], one.windows[np.isin(one.windows, rows)])
        np.testing.assert_array_equal(rows[trained(some, other)], np.intersect1d(trained(work, one), rows))
        tested = np.concatenate([some.splits[number].tested for number in other.splits])
        np.testing.assert_array_equal(tested, other.windows)
        votes = np.bincount(labels[rows][other.windows], other.weight, 3)
        np.testing.assert_allclose(votes[other.testable], 1)  # one an activity, however many are left


def test_an_activity_none_of_whose_windows_is_left_cannot_be_tested():
    labels, clip, fold, is_test = library()
    rows = np.flatnonzero(labels != 1)
    some = plan(labels, clip, fold, is_test).among(rows, labels[rows])
    for trial in (some.whole, *some.pairs[0]):
        np.testing.assert_array_equal(trial.testable, [True, False, True])


def test_copies_of_a_clip_stay_on_its_side():
    labels, clip, fold, is_test = library()
    twice = [np.tile(values, 2) for values in (labels, clip, fold)]
    work = plan(*twice, np.r_[is_test, np.zeros(len(clip), bool)])
    np.testing.assert_array_equal(work.block[: len(clip)], work.block[len(clip) :])


def test_two_or_three_subjects_are_compared_one_with_another():
    labels, clip, fold, is_test = library(subjects=3)
    work = plan(labels, clip, fold, is_test, by_subject=True)
    assert not work.disjoint
    assert len(work.pairs) == 3
    assert work.shrink == 6
    for first, second in work.pairs:
        assert len(np.unique(fold[first.windows])) == 1
        assert not np.isin(fold[first.windows], fold[second.windows]).any()


def test_four_subjects_are_halved_in_all_three_ways():
    labels, clip, fold, is_test = library(subjects=4)
    work = plan(labels, clip, fold, is_test, by_subject=True)
    assert work.disjoint
    together = {frozenset(fold[trial.windows].tolist()) for pair in work.pairs for trial in pair}
    assert {len(half) for half in together} == {2}
    assert len(together) == 6


def test_an_odd_clip_falls_on_either_side():
    """Of 200 activities of three clips half have two on a side: 300 of 600, with a deviation of 7."""
    labels = np.repeat(np.arange(200), 3)
    for side in deal_halves(labels, np.arange(600), seed=0, halvings=4):
        assert set(np.bincount(labels, side)) == {1, 2}
        assert 260 < side.sum() < 340


def test_three_clips_an_activity_cannot_be_halved():
    labels, clip, fold, is_test = library(n_clips=9)
    work = plan(labels, clip, fold, is_test)
    assert work.pairs == ()
    np.testing.assert_array_equal(np.sort(work.whole.windows), np.flatnonzero(is_test))


def test_clips_have_a_vote_each_however_long():
    clip = np.repeat(np.arange(8), [1, 1, 5, 5, 2, 2, 9, 9])
    labels = clip % 2
    work = plan(labels, clip, clip // 2 % 2, np.ones(len(clip), bool), halvings=0)
    weight = np.zeros(len(clip))
    weight[work.whole.windows] = work.whole.weight
    np.testing.assert_allclose(np.bincount(clip, weights=weight), 0.25)


def test_windows_that_every_fold_trains_on_are_in_every_training():
    labels, clip, fold, is_test = library()
    fold = fold.copy()
    fold[clip == 5] = -1
    work = plan(labels, clip, fold, is_test & (clip != 5), halvings=0)
    for split in work.splits:
        assert np.isin(work.block[clip == 5], split.train).all()
