# SPDX-License-Identifier: GPL-3.0-or-later
"""The ridge classifier against scikit-learn's discriminant analysis, and its choice of ridge."""

import numpy as np
import pytest
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from w2w.core.ranking.classifiers import ridge
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import plan

SPLITS = ridge._Splits


def library(seed=0, n_clips=40, n_classes=4, n_sensors=3, n_features=12, spread=1.5):
    """Features of clips around class centres; classes of unequal size."""
    rng = np.random.default_rng(seed)
    clip_label = rng.choice(
        n_classes, size=n_clips, p=np.arange(1, n_classes + 1) / sum(range(n_classes + 1))
    )
    clip_label[: 2 * n_classes] = np.tile(np.arange(n_classes), 2)
    clip = np.repeat(np.arange(n_clips), 5)
    labels = clip_label[clip]
    centres = rng.normal(size=(n_classes, n_sensors, n_features))
    features = centres[labels] + spread * rng.normal(size=(len(clip), n_sensors, n_features))
    return features.astype(np.float32), labels, clip % 5, clip


def linear(alpha):
    return Ridge(alphas=(alpha,))


def reference(features, labels, fold, is_test, alpha):
    """The same protocol as plain loops over scikit-learn, with equal priors.

    A ridge alpha is a shrinkage of alpha / (1 + alpha) where variances within classes are 1.
    """
    named = np.empty((is_test.sum(), features.shape[1]), dtype=int)
    for sensor in range(features.shape[1]):
        for f in np.unique(fold[is_test]):
            train, test = fold != f, is_test & (fold == f)
            x = features[:, sensor].astype(np.float64)
            means = np.stack([x[train & (labels == c)].mean(axis=0) for c in range(labels.max() + 1)])
            x /= np.sqrt(((x - means[labels])[train] ** 2).mean(axis=0))
            model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage=alpha / (1 + alpha))
            model.fit(x[train], labels[train])
            scores = x[test] @ model.coef_.T + model.intercept_ - np.log(model.priors_)
            named[fold[is_test] == f, sensor] = scores.argmax(axis=1)
    return named


@pytest.mark.parametrize("alpha", [0.01, 1.0])
def test_equals_scikit_learn_trained_fold_by_fold(alpha):
    features, labels, fold, _ = library()
    is_test = np.arange(len(labels)) % 5 < 3
    named = linear(alpha).predict_folds(features, labels, fold, is_test)
    np.testing.assert_array_equal(named, reference(features, labels, fold, is_test, alpha))
    assert (named == labels[is_test][:, None]).mean() > 0.5


def test_windows_always_trained_on_are_trained_on_and_not_tested():
    features, labels, fold, _ = library()
    fold = np.where(np.arange(len(fold)) < 100, -1, fold)
    is_test = fold >= 0
    named = linear(0.1).predict_folds(features, labels, fold, is_test)
    np.testing.assert_array_equal(named, reference(features, labels, fold, is_test, 0.1))


def test_one_sensor_alone_is_named_as_among_others():
    features, labels, fold, _ = library(n_sensors=4)
    is_test = np.ones(len(labels), bool)
    together = Ridge(alphas=(0.1,)).predict_folds(features, labels, fold, is_test)
    alone = Ridge(alphas=(0.1,)).predict_folds(features[:, 2:3], labels, fold, is_test)
    np.testing.assert_array_equal(together[:, 2], alone[:, 0])


def test_scale_and_offset_of_features_do_not_matter():
    features, labels, fold, _ = library()
    is_test = np.ones(len(labels), bool)
    other = features.astype(np.float64) * np.geomspace(1e-3, 1e3, 12) + np.linspace(-1, 1, 12)
    first, second = (linear(0.1).predict_folds(x, labels, fold, is_test) for x in (features, other))
    assert (first == second).mean() > 0.998


def test_a_class_between_two_others_is_not_masked():
    """Three classes in a row: least squares onto indicators never names the middle one."""
    rng = np.random.default_rng(5)
    labels = np.arange(900) % 3
    features = (4 * labels[:, None, None] + rng.normal(size=(900, 1, 1))).astype(np.float32)
    named = linear(0.01).predict_folds(features, labels, np.arange(900) // 300, np.ones(900, bool))
    assert (named[labels == 1, 0] == 1).mean() > 0.9


def test_a_feature_that_never_changes_does_no_harm():
    features, labels, fold, _ = library()
    is_test = np.ones(len(labels), bool)
    constant = np.full((*features.shape[:2], 1), 7.0, dtype=np.float32)
    model = linear(0.1)
    with_it = model.predict_folds(np.concatenate([features, constant], axis=2), labels, fold, is_test)
    np.testing.assert_array_equal(with_it, model.predict_folds(features, labels, fold, is_test))


def test_rare_classes_are_named_as_often_as_common_ones_are_missed():
    """Class-balanced: with two overlapping classes of 9 : 1, both are recalled alike."""
    rng = np.random.default_rng(2)
    labels = (rng.random(4000) < 0.1).astype(int)
    features = (labels[:, None, None] + rng.normal(size=(4000, 1, 1))).astype(np.float32)
    named = linear(0.01).predict_folds(features, labels, np.arange(4000) % 4, np.ones(4000, bool))
    recall = [(named[labels == c, 0] == c).mean() for c in (0, 1)]
    assert recall[0] == pytest.approx(recall[1], abs=0.06)


def test_the_chosen_ridge_is_weak_where_noise_must_cancel_and_strong_where_it_is_all_there_is():
    rng = np.random.default_rng(0)
    labels, fold = np.arange(300) % 3, np.arange(300) // 3 % 5
    signal, hum = labels + 0.3 * rng.normal(size=300), 20 * rng.normal(size=300)
    cancelling = np.stack([signal + hum, hum], axis=1)[:, None].astype(np.float32)
    drowned = 5 * rng.normal(size=(300, 1, 300)).astype(np.float32)
    drowned[:, 0, :3] += np.eye(3)[labels] * 8
    model, everywhere = Ridge(), np.ones(300, bool)
    assert model.choose_alpha(cancelling, labels, fold, everywhere) <= 0.01
    assert model.choose_alpha(drowned, labels, fold, everywhere) >= 0.1


@pytest.mark.parametrize(("n_folds", "n_trainings"), [(5, 10), (9, 27)])
def test_the_ridge_is_chosen_as_by_a_training_for_each_part_of_each_fold(monkeypatch, n_folds, n_trainings):
    """Two of five folds leave out each other, so one training tests both."""
    features, labels, _, clip = library(n_clips=180, spread=3)
    fold, is_test = clip % n_folds, np.arange(len(labels)) % 5 < 3
    of_parts = []
    for f in range(n_folds):
        others = [other for other in range(n_folds) if other != f]
        for part in (others[first::4] for first in range(4)):
            kept = fold != f
            tried = features[kept], labels[kept], np.where(np.isin(fold, part), 0, -1)[kept]
            tested = (is_test & np.isin(fold, part))[kept]
            named = [linear(alpha).predict_folds(*tried, tested) for alpha in ridge.ALPHAS]
            right = np.array(named) == labels[kept][tested, None]
            by_class = [right[:, labels[kept][tested] == c].mean(axis=1) for c in range(4)]
            of_parts.append(np.mean(by_class, axis=(0, 2)))
    lag = np.max(np.mean(of_parts, axis=0)) - np.mean(of_parts, axis=0)
    behind = np.array(of_parts)[:, [lag.argmin()]] - of_parts
    allowed = behind.std(axis=0, ddof=1) / np.sqrt(len(behind))
    best = ridge.ALPHAS[np.flatnonzero(lag <= allowed).max()]
    trainings = []
    monkeypatch.setattr(ridge, "_Splits", lambda *of: trainings.append(len(of[2])) or SPLITS(*of))
    assert Ridge().choose_alpha(features, labels, fold, is_test) == best
    assert trainings == [n_trainings]
    monkeypatch.setattr(ridge, "TASK_SENSORS", 1)
    assert Ridge().choose_alpha(features, labels, fold, is_test, map) == best  # each sensor elsewhere
    assert trainings == [n_trainings] * (1 + features.shape[1])


@pytest.mark.slow
def test_a_little_noise_does_not_change_the_ridge():
    """Single folds tell too little: here each would waver between ridges that do the same."""
    features, labels, fold, _ = library(seed=2, n_sensors=8, spread=2.5)
    is_test, chosen = np.ones(len(labels), bool), set()
    for seed in range(8):
        noise = 0.01 * np.random.default_rng(seed).normal(size=features.shape)
        chosen.add(Ridge().choose_alpha((features + noise).astype(np.float32), labels, fold, is_test))
    assert len(chosen) == 1


def test_threads_repetition_and_sensors_at_once_change_nothing():
    features, labels, fold, _ = library(n_sensors=6)
    is_test = np.ones(len(labels), bool)
    told = []
    one = Ridge(workers=1).predict_folds(features, labels, fold, is_test, told.append)
    two = Ridge(workers=2).predict_folds(features, labels, fold, is_test)
    np.testing.assert_array_equal(one, two)
    np.testing.assert_allclose(told, [0.5, 1])  # three sensors at once


def test_trainings_on_few_windows_and_on_many_name_alike(monkeypatch):
    """Folds of unequal size: some trainings have fewer windows than features, others more."""
    rng = np.random.default_rng(8)
    labels = np.arange(120) % 3
    features = rng.normal(size=(120, 4, 60)).astype(np.float32)
    features[..., 0] += labels[:, None]
    fold, is_test = np.where(np.arange(120) < 90, 0, 1 + np.arange(120) % 2), np.ones(120, dtype=bool)
    both = Ridge(alphas=(0.1,)).predict_folds(features, labels, fold, is_test)
    for factor in (0.0, 100.0):
        monkeypatch.setattr("w2w.core.ranking.classifiers.discriminant.FEW", factor)
        alone = Ridge(alphas=(0.1,)).predict_folds(features, labels, fold, is_test)
        np.testing.assert_array_equal(both, alone)


@pytest.mark.parametrize("seed", range(4))
def test_features_that_vary_in_a_few_windows_alone_stop_nothing(seed):
    features, labels, fold, clip = library(seed, n_clips=120, n_features=40)
    rng = np.random.default_rng(seed)
    features[..., 20:26] = 0
    for feature in range(20, 26):
        features[rng.choice(len(clip), 3), :, feature] = 3 * rng.normal(size=(3, 1))
    is_test = np.ones(len(clip), dtype=bool)
    with_them, without = (
        Ridge().predict_folds(some, labels, fold, is_test)
        for some in (features, np.delete(features, range(20, 26), axis=2))
    )
    assert (with_them == without).mean() > 0.97


def test_a_trials_folds_are_trained_from_a_few_parts_that_they_share():
    _, labels, fold, clip = library()
    work = plan(labels, clip, fold, np.ones(len(labels), dtype=bool))
    shared = ridge._Splits(labels, work.block, work.splits)._shared
    assert len(shared) <= len(work.trials) - len(work.pairs)  # both halves of the clips share theirs
    for each in shared:
        for number, parts in zip(range(len(work.splits))[each.splits], each.of_parts, strict=True):
            trained = np.isin(work.block, work.splits[number].train)
            np.testing.assert_array_equal(parts[each.part] > 0, trained)
            assert len(parts) <= len(each.of_parts) + 2
