# SPDX-License-Identifier: GPL-3.0-or-later
"""Areas under ROC curves and F1 by window, against scikit-learn."""

import numpy as np
from sklearn.metrics import f1_score, roc_auc_score

from w2w.core.ranking.f1 import class_auc, window_f1


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
