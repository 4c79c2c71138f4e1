# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sets and what they would reach on other clips: halves do not believe the proxy."""

from dataclasses import replace

import numpy as np
import pytest

from tests.core.selection.made_sets import NAMES, N, alone, library, prepare, terms
from w2w.core.selection.headline import short
from w2w_studies.paper import promised as paper
from w2w_studies.paper.promised import LargePromises, exact_by_half, greedy_by_half, map_of, promised
from w2w_studies.paper.subsets import exact_subset, greedy_subset

CHANCE = 1 / len(NAMES)


def chosen(found, target=1.0, size=4, choose=greedy_subset, by_half=greedy_by_half):
    """A set by the proxy over the map of all clips, with its promise."""
    subset = choose(map_of(found.whole), target, size)
    return promised(subset, LargePromises(found, terms(size)), alone(found), by_half)


@pytest.fixture(scope="module")
def tests():
    return prepare(*library())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("choose", "by_half"), [(greedy_subset, greedy_by_half), (exact_subset, exact_by_half)]
)
def test_where_labels_mean_nothing_the_proxy_flatters_and_the_promise_does_not(choose, by_half):
    naive, expected = [], []
    for seed in range(4):
        found = prepare(*library(seed, shuffled=True))
        subset = chosen(found, choose=choose, by_half=by_half)
        naive.append(subset.mean_max_after_each[-1])
        expected.append(subset.promise.f1[-1].mean())
    assert np.mean(naive) > CHANCE + 0.1
    assert np.mean(expected) < CHANCE + 0.06


@pytest.mark.slow
def test_the_promise_is_what_another_library_of_the_kind_gives():
    differences = []
    for seed in range(4):
        here, there = prepare(*library(2 * seed)), prepare(*library(2 * seed + 1))
        subset = chosen(here, size=2)
        delivered = there.whole.f1_of_first(subset.order)[1].mean()
        differences.append(subset.promise.mean[-1] - delivered)
    assert abs(np.mean(differences)) < 0.05


def test_a_set_says_first_what_other_clips_would_give(tests):
    subset = chosen(tests)
    made = subset.promise
    assert len(made.mean) == len(subset.order)
    assert made.low[-1] <= made.mean[-1] <= made.high[-1]
    said = subset.sentence()
    assert said.index(f"expected F1 of {short(made.mean[-1])} on other clips") < said.index("mean-max F1")
    assert replace(subset, promise=None).sentence() == subset.proxy_sentence()
    assert "not known" in replace(subset, promise=None).expected_sentence()


def test_halves_choose_by_the_proxy_over_their_own_map(tests):
    (half, _), free = tests.pairs[0], terms(3)
    assert greedy_by_half(half, free, 3) == list(greedy_subset(map_of(half), 2.0, 3).order)
    exact = exact_by_half(half, free, 2)
    assert set(exact) == set(exact_subset(map_of(half), 2.0, 2).order)
    assert len(exact_by_half(half, free, 6)) <= 6
    wished = terms(3, allowed=np.arange(N) != 5, required=[[10, 11], [4, 5]])
    for choose in (greedy_by_half, exact_by_half):
        order = choose(half, wished, 3)
        assert 4 in order
        assert np.isin(order, [10, 11]).any()


def test_the_level_of_large_sets_is_that_of_all_of_them_at_every_size(tests, monkeypatch):
    quick = LargePromises(tests, terms(N)).level(tests.whole, N)
    monkeypatch.setattr(paper, "FEW_SENSORS", N)
    every = LargePromises(tests, terms(N)).level(tests.whole, N)
    np.testing.assert_array_equal(quick[:6], every[:6])
    assert not np.array_equal(quick[6:], every[6:])
    np.testing.assert_allclose(quick.mean(axis=1), every.mean(axis=1), atol=0.03)


@pytest.mark.slow
def test_of_large_sets_that_halves_choose_some_sizes_are_tested(tests, monkeypatch):
    order = list(range(N))
    quick = LargePromises(tests, terms(N)).of(order, lambda *_: order, (0.5, 0.4, 0.6))
    monkeypatch.setattr(paper, "FEW_SENSORS", N)
    every = LargePromises(tests, terms(N)).of(order, lambda *_: order, (0.5, 0.4, 0.6))
    np.testing.assert_array_equal(quick.raw, every.raw)  # on all clips every size is
    np.testing.assert_array_equal(quick.f1[:6], every.f1[:6])
    assert not np.array_equal(quick.f1[6:], every.f1[6:])
    np.testing.assert_allclose(quick.mean, every.mean, atol=0.03)


def test_a_level_that_is_known_up_to_any_size_grows_from_there(tests):
    promises = LargePromises(tests, terms(N))
    known, grown = promises.level(tests.whole, 7), promises.level(tests.whole, N)
    assert len(grown) == N
    np.testing.assert_array_equal(grown[:7], known)
    np.testing.assert_allclose(grown, LargePromises(tests, terms(N)).level(tests.whole, N), atol=0.05)
