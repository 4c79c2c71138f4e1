# SPDX-License-Identifier: GPL-3.0-or-later
"""The forest baseline is scikit-learn's, fold by fold, and reproducible."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.ensemble import ExtraTreesClassifier

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.classifiers.trees import extra_trees


def library(seed=0, n_clips=24, n_places=3):
    rng = np.random.default_rng(seed)
    clip = np.repeat(np.arange(n_clips), 4)
    labels = clip % 3
    centres = rng.normal(size=(3, n_places, 8)) * np.array([2.0, 1.0, 0.0])[:, None]
    features = centres[labels] + rng.normal(size=(len(clip), n_places, 8))
    return features.astype(np.float32), labels, clip // 3 % 4, clip


@pytest.mark.slow
def test_equals_scikit_learn_trained_fold_by_fold_whatever_the_threads_and_blocks():
    features, labels, fold, _ = library()
    fold[:8] = -1
    is_test = (np.arange(len(labels)) % 2 == 0) & (fold >= 0)
    expected = np.empty((is_test.sum(), 3), dtype=int)
    for place in range(3):
        for f in range(4):
            test = is_test & (fold == f)
            forest = ExtraTreesClassifier(100, random_state=4).fit(
                features[fold != f, place], labels[fold != f]
            )
            expected[fold[is_test] == f, place] = forest.predict(features[test, place])
    for workers, block_bytes in ((1, 1), (2, 2**20)):
        told = []
        model = replace(extra_trees(seed=4), workers=workers, block_bytes=block_bytes)
        named = model.predict_folds(features, labels, fold, is_test, told.append)
        np.testing.assert_array_equal(named, expected)
        assert told[-1] == 1.0


@pytest.mark.slow
def test_by_name_it_ranks_places_by_what_they_tell():
    features, labels, _, clip = library()
    activity = np.array(["bow", "run", "walk"])[labels]
    everywhere = np.ones(len(clip), bool)
    maps = [
        utility_map(
            features,
            CrossValidation(activity, clip, None, everywhere, ("bow", "run", "walk"), folds=3, seed=seed),
            "trees",
            resamples=20,
        )
        for seed in (2, 2, 3)
    ]
    assert maps[0].classifier == "trees"
    assert (np.diff(maps[0].mean) < 0).all()
    np.testing.assert_array_equal(maps[0].predictions, maps[1].predictions)
    assert (maps[0].predictions != maps[2].predictions).any()
