# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores added up over windows: what the definition gives from all of them at once, in memory that stays."""

import tracemalloc
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.ranking.classifiers import ridge
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.f1 import try_patches, window_f1
from w2w.core.ranking.halves import CrossValidation, Predictions, plan
from w2w.core.ranking.utility import utility_map
from w2w.core.windows.inputs import ArrayBlocks

pytestmark = pytest.mark.later

A = 4


def windows(clips=12, of_clip=6, seed=0):
    """Labels, clips and folds of windows, of which every other one is tested."""
    clip = np.repeat(np.arange(A * clips), of_clip)
    order = np.random.default_rng(seed).permutation(len(clip))
    clip = clip[order]
    return clip % A, clip, clip // A % 3, np.arange(len(clip)) % 2 == 0


@pytest.mark.parametrize("by_subject", [False, True])
def test_sums_over_some_windows_at_a_time_give_what_all_at_once_would(by_subject):
    labels, clip, fold, is_test = windows()
    work = plan(labels, clip, fold, is_test, by_subject)
    rng = np.random.default_rng(1)
    given = [rng.normal(size=(1, len(split.tested), A)) for split in work.splits]
    parts = []
    for split in rng.permutation(len(given)).tolist():
        tested, named = work.splits[split].tested, given[split].argmax(axis=2)
        ends = [0, *np.sort(rng.integers(len(tested), size=2)), len(tested)]
        parts += [
            Predictions(split, tested[first:last], named[:, first:last]) for first, last in pairwise(ends)
        ]

    class Told:
        def predict_splits(self, _source, _labels, _block, _splits, _alpha, receive, _progress):
            receive(1, parts)

    trial = SimpleNamespace(labels=labels, is_test=is_test, plan=work)
    tried = try_patches(Told(), ArrayBlocks(np.empty((len(labels), 3, 1))), trial, 0.1, (0, 3))
    f1 = tried.f1
    assert f1.shape == (len(work.trials), A, 3)
    for number, trial in enumerate(work.trials):
        scores = np.concatenate([given[split] for split in trial.splits], axis=1)
        true = labels[trial.windows]
        np.testing.assert_array_equal(f1[number, :, 1], window_f1(scores[0].argmax(axis=1), true, A))
    whole = np.concatenate([given[split][0] for split in work.whole.splits]).argmax(axis=1)
    position = np.cumsum(is_test) - 1
    np.testing.assert_array_equal(tried.predictions[position[work.whole.windows], 1], whole)


def features(labels, n_patches=5, width=6, seed=2):
    rng = np.random.default_rng(seed)
    trace = rng.normal(size=(A, n_patches, width)) * np.linspace(0.2, 1, n_patches)[:, None]
    return (trace[labels] + rng.normal(size=(len(labels), n_patches, width))).astype(np.float32)


@pytest.mark.slow
def test_a_map_is_the_same_however_many_windows_are_looked_at_at_once(monkeypatch):
    labels, clip, _, is_test = windows()
    names = np.array(list("abcd"))
    maps = []
    for at_once in (ridge.WINDOWS_AT_ONCE, 5):
        monkeypatch.setattr(ridge, "WINDOWS_AT_ONCE", at_once)
        protocol = CrossValidation(names[labels], clip, None, is_test, list(names), 3)
        maps.append(utility_map(features(labels), protocol))
    whole, parts = maps
    np.testing.assert_array_equal(whole.predictions, parts.predictions)
    np.testing.assert_array_equal(whole.f1, parts.f1)
    np.testing.assert_allclose(whole.expected_f1, parts.expected_f1, atol=1e-6)
    np.testing.assert_allclose(whole.expected_mean, parts.expected_mean, atol=1e-6)


@pytest.mark.slow
def test_what_a_patch_takes_does_not_grow_with_the_windows(monkeypatch):
    monkeypatch.setattr(ridge, "WINDOWS_AT_ONCE", 256)
    peaks, counts = [], []
    for clips in (100, 800):
        labels, clip, fold, is_test = windows(clips)
        inputs = features(labels, 2, 40)
        work = plan(labels, clip, fold, is_test)
        model, source = Ridge(alphas=(0.1,), workers=1), ArrayBlocks(inputs)
        trial = SimpleNamespace(labels=labels, is_test=is_test, plan=work)
        tracemalloc.start()
        try_patches(model, source, trial, 0.1, (0, 2))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        counts.append(len(labels))
    # some indices a window are kept, 20 bytes; its scores would be 16 bytes more, its features 320. The limit
    # leaves 170 kB to what other threads allocate meanwhile, which is counted, too
    assert peaks[1] - peaks[0] < 30 * (counts[1] - counts[0])


@pytest.mark.slow
def test_patches_tried_some_at_a_time_give_the_same_map():
    labels, clip, _, is_test = windows()
    names = np.array(list("abcd"))
    arguments = features(labels, 35), CrossValidation(names[labels], clip, None, is_test, list(names), 3)
    told = []
    whole, parts = utility_map(*arguments), utility_map(*arguments, progress=told.append, spread=map)
    for name in ("predictions", "expected_f1", "expected_mean", "errors", "mean_samples"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(parts, name))
    assert told == [1 / 3, 2 / 3, 1.0]
