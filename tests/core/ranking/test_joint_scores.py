# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches worn together equal discriminant analysis on their features side by side."""

import numpy as np
import pytest

from w2w.core.ranking.joint_scores import JointScores, Training

pytestmark = pytest.mark.later

N, W, D, A = 6, 60, 5, 3
RIDGE = 0.1


@pytest.fixture(params=[D, 2 * W], ids=["many windows", "few windows"])
def library(request):
    rng = np.random.default_rng(0)
    labels = np.arange(W) % A
    width = request.param
    features = rng.normal(size=(N, W, width)) + rng.normal(size=(N, A, width))[:, labels]
    features -= features.mean(axis=1, keepdims=True)
    trainings = [Training(np.arange(0, 40), np.arange(40, 60)), Training(np.arange(20, 60), np.arange(0, 20))]
    return features.astype(np.float32), labels, trainings


def side_by_side(features, labels, training, ridge):
    """Ridge discriminant analysis by its definition, in double precision."""
    trained = [inputs[training.trained].astype(float) for inputs in features]
    true = labels[training.trained]
    means = [np.array([rows[true == a].mean(axis=0) for a in range(A)]) for rows in trained]
    scale = [
        np.sqrt(((rows - mean[true]) ** 2).mean(axis=0)) for rows, mean in zip(trained, means, strict=True)
    ]
    within = np.hstack([(r - m[true]) / s for r, m, s in zip(trained, means, scale, strict=True)])
    centres = np.hstack([m / s for m, s in zip(means, scale, strict=True)])
    tested = np.hstack([f[training.tested] / s for f, s in zip(features, scale, strict=True)])
    covariance = within.T @ within / len(true) + ridge * len(features) * np.eye(within.shape[1])
    slopes = np.linalg.solve(covariance, centres.T)
    return tested @ slopes - 0.5 * (centres.T * slopes).sum(axis=0)


@pytest.mark.parametrize("worn", [(), (2,), (2, 5), (2, 5, 0, 3, 1)])  # the last is wider than its windows
def test_each_patch_added_equals_the_definition(library, worn):
    features, labels, trainings = library
    joint = JointScores(features, labels, trainings, RIDGE)
    for candidate, scores in zip((4, 1), joint.of_added(worn, [4, 1], np.copy), strict=True):
        sets = features[[*worn, candidate]]
        wanted = np.concatenate([side_by_side(sets, labels, training, RIDGE) for training in trainings])
        if candidate not in worn:
            np.testing.assert_allclose(scores, wanted, rtol=1e-3, atol=2e-3 * np.abs(wanted).max())


def test_the_way_is_chosen_by_how_many_windows_there_are(library):
    features, labels, trainings = library
    joint = JointScores(features, labels, trainings, RIDGE)
    many = features.shape[2] == D
    assert [joint._is_wide(worn) for worn in (0, 5, 11)] == [not many, not many, True]


def test_the_first_and_the_first_two_are_what_adding_gives(library):
    features, labels, trainings = library
    joint = JointScores(features, labels, trainings, RIDGE)
    order = [3, 0, 5]
    for size, scores in enumerate(next(joint.each_first_of([order], range(1, len(order) + 1))), start=1):
        (added,) = joint.of_added(order[: size - 1], [order[size - 1]], np.copy)
        np.testing.assert_allclose(scores, added, atol=2e-3 * np.abs(added).max())
    np.testing.assert_array_equal(joint.windows, [*range(40, 60), *range(20)])
    some = list(joint.each_first_of([order, order[::-1]], sizes=[1, 3]))
    for one, scores in zip((order, order[::-1]), some, strict=True):
        every = next(joint.each_first_of([one], range(1, len(one) + 1)))
        np.testing.assert_allclose(scores, every[::2], rtol=1e-5)  # summed in other steps


@pytest.mark.parametrize("kept", [0, 3, N])  # kernels, in memory
def test_what_is_kept_changes_nothing(library, monkeypatch, kept):
    features, labels, trainings = library
    monkeypatch.setattr("w2w.core.ranking.joint_scores.KEPT_VALUES", kept * 40**2)
    joint, new = (JointScores(features, labels, trainings, RIDGE) for _ in range(2))
    for worn in ([2], [2, 4], [2, 4, 1]):
        scores = joint.of_added(worn, [0, 3, 5], np.copy)
        again = joint.of_added(worn, [5, 3, 0], np.copy)
        np.testing.assert_array_equal(scores, again[::-1])
    np.testing.assert_array_equal(scores, new.of_added(worn, [0, 3, 5], np.copy))


def test_an_activity_without_training_is_never_named(library):
    features, labels, _ = library
    seen = np.flatnonzero(labels[:40] != 2)
    joint = JointScores(features, labels, [Training(seen, np.arange(40, 60))], RIDGE)
    for scores in next(joint.each_first_of([[0, 1]], [1, 2])):
        assert (scores[:, 2] == -np.inf).all()
        assert np.isfinite(scores[:, :2]).all()


@pytest.mark.parametrize("worn", [(), (3,), (3, 0), (3, 0, 4)])
def test_sums_that_trainings_share_give_what_each_training_gives(worn):
    """Real proportions: classes far apart in small features, people left out, windows all are trained on."""
    rng = np.random.default_rng(3)
    n_windows, width, people = 300, 20, 7
    labels, person = rng.integers(0, 5, n_windows), rng.integers(-1, people, n_windows)
    features = rng.normal(size=(N, n_windows, width)) @ rng.normal(size=(width, width))
    features += 30 * rng.normal(size=(N, 5, width))[:, labels]
    features[:, :, 0] = 0.7  # never varies
    features -= features.mean(axis=1, keepdims=True)
    trainings = [
        Training(np.flatnonzero(person != one), np.flatnonzero(person == one)) for one in range(people)
    ]
    features = features.astype(np.float32)
    joint = JointScores(features, labels, trainings, RIDGE)
    by_features, by_kernels = joint.adding_by_features(worn), joint.adding_by_kernels(worn)
    for scores, wanted in zip(by_features([1, 5]), by_kernels([1, 5]), strict=True):
        np.testing.assert_allclose(scores, wanted, atol=1e-4 * np.abs(wanted).max())
