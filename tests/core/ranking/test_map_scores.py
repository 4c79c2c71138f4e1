# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores by ranks, areas under ROC curves and F1 by window, against counts by hand and scikit-learn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import f1_score, roc_auc_score

from w2w.core.ranking.map_scores import (
    class_auc,
    class_auc_at_most,
    rank_score,
    rank_sums,
    ranks_of,
    window_f1,
)


def test_two_windows_by_hand():
    """Three activities: shares of the places are 6/11, 3/11 and 2/11."""
    scores = np.array([[3.0, 2.0, 1.0], [3.0, 2.0, 1.0]])
    found = rank_score(scores, np.array([0, 1]), np.ones(2))
    first, second = 6 / 11, 3 / 11
    assert found[0] == pytest.approx((2 * first / (2 * first + 1) + 1) / 2)  # outscores both others
    assert found[1] == pytest.approx((2 * second / (2 * second + 1) + 1 / 2) / 2)  # one of two
    assert np.isnan(found[2])


def test_a_near_miss_counts_more_than_a_far_one():
    true = np.array([0, 0])
    near, far = np.array([[2.0, 3.0, 1.0]] * 2), np.array([[1.0, 3.0, 2.0]] * 2)
    assert rank_score(near, true, np.ones(2))[0] > rank_score(far, true, np.ones(2))[0]


def test_a_weight_of_two_is_a_window_twice():
    rng = np.random.default_rng(0)
    scores, true = rng.normal(size=(30, 4)), np.arange(30) % 4
    twice = np.r_[np.arange(30), 7]
    weight = np.ones(30)
    weight[7] = 2
    np.testing.assert_allclose(
        rank_score(scores, true, weight), rank_score(scores[twice], true[twice], np.ones(31))
    )


@pytest.mark.parametrize("n_activities", [2, 11])
def test_sums_are_those_of_ranks_by_stable_sorting(n_activities):
    rng = np.random.default_rng(2)
    scores = rng.normal(size=(3, 40, n_activities)).astype(np.float32)
    scores[:, :10] = scores[:, :10].round()  # ties, zeros of both signs
    scores[:, :, 1] = -np.inf  # never trained
    true, weight = rng.integers(0, n_activities, 40), rng.random(40)
    rank = np.argsort(np.argsort(-scores, axis=-1, kind="stable"), axis=-1)
    of_true = np.take_along_axis(rank, np.broadcast_to(true[:, None], (3, 40, 1)), -1)[..., 0]
    everyone = (1 / np.arange(1, n_activities + 1)).sum()
    sums = rank_sums(ranks_of(scores.transpose(2, 0, 1)), true, weight)
    for found, ranks, of_its_true in zip(sums, rank, of_true, strict=True):
        for activity in range(n_activities):
            own = true == activity
            expected = [
                (weight / (1 + of_its_true) / everyone)[own].sum(),
                (weight / (1 + ranks[:, activity]) / everyone).sum(),
                weight[own].sum(),
                (weight * (1 - of_its_true / (n_activities - 1)))[own].sum(),
            ]
            np.testing.assert_allclose(found[:, activity], expected, rtol=1e-12)


@pytest.mark.parametrize("n_activities", [1, 5, 300])
def test_ranks_are_those_of_stable_sorting_however_many_activities(n_activities):
    scores = np.random.default_rng(4).normal(size=(n_activities, 2, 30)).round(1)
    wanted = np.argsort(np.argsort(-scores, axis=0, kind="stable"), axis=0)
    np.testing.assert_array_equal(ranks_of(scores), wanted)


def test_f1_by_window_equals_scikit_learns():
    rng = np.random.default_rng(1)
    true, named = rng.integers(0, 5, 200), rng.integers(0, 5, 200)
    np.testing.assert_allclose(window_f1(named, true, 5), f1_score(true, named, average=None))


def test_the_area_of_each_activity_equals_scikit_learns():
    rng = np.random.default_rng(2)
    true = rng.integers(0, 4, 120)
    scores = rng.normal(size=(120, 4)) + np.eye(4)[true]
    about = scores - scores.mean(axis=1, keepdims=True)
    wanted = [roc_auc_score(true == activity, about[:, activity]) for activity in range(4)]
    np.testing.assert_allclose(class_auc(scores, true, np.ones(120)), wanted)


def test_an_activity_that_was_never_trained_is_told_from_none():
    scores = np.array([[2.0, 1.0, -np.inf], [1.0, 2.0, -np.inf], [1.0, 0.0, -np.inf]])
    areas = class_auc(scores, np.array([0, 1, 2]), np.ones(3))
    assert areas[2] == 0
    assert np.isfinite(areas).all()


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_the_areas_are_at_most_what_the_first_windows_allow_and_reach_it(seed, seen):
    rng = np.random.default_rng(seed)
    true, weight = rng.integers(0, 3, 40), rng.uniform(0.1, 1, 40)
    first = rng.normal(size=(40, 4))
    whole = class_auc(first, true, weight)
    there = np.isfinite(whole)
    assert (whole[there] <= class_auc_at_most(first[:seen], true, weight)[there] + 1e-12).all()
    without_fault = np.where(np.arange(40)[:, None] < seen, first, 99.0 * np.eye(4)[true])
    limit = class_auc_at_most(first[:seen], true, weight)
    np.testing.assert_allclose(class_auc(without_fault, true, weight)[there], limit[there])
