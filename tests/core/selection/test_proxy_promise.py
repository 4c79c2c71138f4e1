# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sets and what they would reach on other clips: halves do not believe the proxy."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.selection import promise as promising
from w2w.core.selection.exact import LARGEST
from w2w.core.selection.promise import _level, promise
from w2w.core.selection.proxy_promise import exact_by_half, greedy_by_half, promised
from w2w.core.selection.subsets import exact_subset, greedy_subset

from .made_sets import NAMES, N, alone, library, prepare, terms

CHANCE = 1 / len(NAMES)


def chosen(found, target=1.0, size=4, choose=greedy_subset, by_half=greedy_by_half):
    """A set by the proxy over the map of all clips, with its promise."""
    free = replace(terms(size), f1=found.whole.map)
    return promised(choose(free.f1, target, size), found, free, alone(found), by_half)


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
    assert said.index(f"expected F1 of {made.mean[-1]:.3f} on other clips") < said.index("mean-max F1")
    assert replace(subset, promise=None).sentence() == subset.proxy_sentence()
    assert "not known" in replace(subset, promise=None).expected_sentence()


def test_halves_choose_by_the_proxy_over_their_own_map(tests):
    (half, _), free = tests.pairs[0], terms(3)
    assert greedy_by_half(half, free, 3) == list(greedy_subset(half.map, 2.0, 3).order)
    exact = exact_by_half(half, free, 2)
    assert set(exact) == set(exact_subset(half.map, 2.0, 2).order)
    assert len(exact_by_half(half, free, LARGEST + 1)) <= LARGEST + 1
    wished = terms(3, allowed=np.arange(N) != 5, required=[[10, 11], [4, 5]])
    for choose in (greedy_by_half, exact_by_half):
        order = choose(half, wished, 3)
        assert 4 in order
        assert np.isin(order, [10, 11]).any()


def test_random_sets_are_tested_once_for_all_that_is_chosen_under_the_same_terms(tests, monkeypatch):
    free = replace(terms(3), f1=tests.whole.map)
    expected = (0.5, 0.4, 0.54)
    promise(tests, free, [0, 4, 1], greedy_by_half, expected)
    tested = []
    f1_of_firsts = type(tests.whole).f1_of_firsts

    def f1_of_firsts_told(one, orders, sizes=None):
        tested.extend(orders)
        return f1_of_firsts(one, orders, sizes)

    monkeypatch.setattr(type(tests.whole), "f1_of_firsts", f1_of_firsts_told)
    again = promise(tests, free, [0, 4], greedy_by_half, expected)
    assert len(tested) == 1 + 2 * len(tests.pairs)  # the set itself, and each half's choice
    assert len(again.mean) == 2


@pytest.mark.parametrize("required", [(), ([10, 11], [4, 5])])
def test_random_sets_that_grow_are_as_good_as_larger_ones_from_the_start(tests, required):
    free, anew = terms(4, required=required), terms(4, required=required)
    _level(tests.whole, free, 1, 0)
    grown = _level(tests.whole, free, 4, 0)
    np.testing.assert_array_equal(grown, _level(tests.whole, anew, 4, 0))


def test_the_level_of_large_sets_is_that_of_all_of_them_at_every_size(tests, monkeypatch):
    free, anew = terms(N), terms(N)
    quick = _level(tests.whole, free, N, 0)
    monkeypatch.setattr(promising, "FEW_SENSORS", N)
    every = _level(tests.whole, anew, N, 0)
    np.testing.assert_array_equal(quick[:6], every[:6])
    assert not np.array_equal(quick[6:], every[6:])
    np.testing.assert_allclose(quick.mean(axis=1), every.mean(axis=1), atol=0.03)


def test_of_large_sets_that_halves_choose_some_sizes_are_tested(tests, monkeypatch):
    order = list(range(N))
    quick = promise(tests, replace(terms(N), f1=tests.whole.map), order, greedy_by_half, (0.5, 0.4, 0.6))
    monkeypatch.setattr(promising, "FEW_SENSORS", N)
    every = promise(tests, replace(terms(N), f1=tests.whole.map), order, greedy_by_half, (0.5, 0.4, 0.6))
    np.testing.assert_array_equal(quick.raw, every.raw)  # on all clips every size is
    np.testing.assert_array_equal(quick.f1[:6], every.f1[:6])
    assert not np.array_equal(quick.f1[6:], every.f1[6:])
    np.testing.assert_allclose(quick.mean, every.mean, atol=0.03)


def test_a_level_that_is_known_up_to_any_size_grows_from_there(tests):
    free = terms(N)
    known = _level(tests.whole, free, 7, 0)
    grown = _level(tests.whole, free, N, 0)
    assert len(grown) == N
    np.testing.assert_array_equal(grown[:7], known)
    np.testing.assert_allclose(grown, _level(tests.whole, terms(N), N, 0), atol=0.05)


def test_clips_that_cannot_be_halved_are_said_to_tell_nothing():
    features, names, clip = library()
    few = np.isin(clip % 12, [0, 1, 2])
    found = prepare(features[few], names[few], clip[few])
    assert not found.pairs
    made = chosen(found, size=2).promise
    assert not made.known
    assert (made.low[-1], made.high[-1]) == (0, 1)
    assert "cannot be compared" in made.text()


@pytest.mark.parametrize(
    ("whole", "half", "promised_f1"), [(0.5, 0.4, 0.54), (0.98, 0.9, 0.98 + 0.04 * 0.0196 / 0.09)]
)
def test_less_is_gained_where_less_is_left(whole, half, promised_f1):
    """Halves gain .04 over random sets; on all clips these are as good as they can be, or are not."""
    free = terms(2)

    class Judged:
        single = np.arange(9.0)  # what is chosen by repeats

        def __init__(self, level, f1):
            self.level, self.f1, self.delivered = (free, np.full((2, 4), level)), f1, {}

        def f1_of_first(self, _):
            return np.full((2, 4), self.f1)

        def f1_of_firsts(self, *_):
            return np.full((1, 2, 4), self.f1)

    one, other = Judged(half, half + 0.04), Judged(half, half + 0.04)
    plan = SimpleNamespace(disjoint=True, shrink=4.0)
    found = SimpleNamespace(
        whole=Judged(whole, 1.0), pairs=((one, other),), plan=plan, seed=0, weights=np.ones(4)
    )
    made = promise(found, free, [0, 4], lambda *_: [0, 4], (0.3, 0.2, 0.4))
    assert made.mean[1] == pytest.approx(promised_f1)
