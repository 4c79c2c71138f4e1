# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chosen set is promised to give is what it gives, over many made-up libraries."""

from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.selection.constraints import Terms
from w2w.core.selection.joint import ByHalves
from w2w.core.selection.promise import Promises, rising

from .made_sets import library, prepare, terms

pytestmark = pytest.mark.later

PATCHES, K = 60, 3
FREE = Terms(np.ones(PATCHES, bool), [], np.ones(PATCHES), K)
SPREAD = 0.05
"""Standard deviation of the patches' true F1."""


def reached(values, order):
    """F1 of the first patch, the first two, and so on."""
    return 0.5 + np.cumsum(values[list(order)] - 0.5 + 0.1) / K


class Measured:
    """Tests of some clips: a patch's true F1 and noise; each patch of a set adds its share, and some."""

    def __init__(self, truth, noise, rng):
        self.single = truth + noise * rng.normal(size=PATCHES)

    def f1_of_first(self, order):
        return reached(self.single, order)[:, None]

    def f1_of_firsts(self, orders, sizes):
        return np.array([self.f1_of_first(order)[np.array(sizes) - 1] for order in orders])


def best_first(tests, _terms, size):
    return (-tests.single).argsort()[:size]


def world(noise, seed, disjoint=True):
    """Promise of the set that a library chooses, and what the set truly gives."""
    rng = np.random.default_rng(seed)
    truth = 0.5 + SPREAD * rng.normal(size=PATCHES)
    halves = tuple(Measured(truth, noise * np.sqrt(2), rng) for _ in range(2))
    whole = Measured(truth, 0.0, rng)
    whole.single = (halves[0].single + halves[1].single) / 2
    plan = SimpleNamespace(disjoint=disjoint, shrink=4.0)
    tests = SimpleNamespace(
        whole=whole, pairs=(halves,), plan=plan, seed=seed, weights=np.ones(1), most_shown=1.0
    )
    order = best_first(whole, None, K)
    made = Promises(tests, FREE).of(order, best_first, (0.0, 0.0, 1.0))
    return made.mean[1:], reached(truth, order)[1:]


@pytest.mark.parametrize(("noise", "seeds"), [(0.02, 80), pytest.param(0.1, 200, marks=pytest.mark.slow)])
def test_all_clips_choose_better_than_the_halves_that_tell_of_it(noise, seeds):
    promised, given = np.mean([world(noise, seed) for seed in range(seeds)], axis=0)
    np.testing.assert_allclose(promised, given, atol=0.006)


@pytest.mark.slow
def test_what_halves_gain_alone_would_be_too_little(monkeypatch):
    monkeypatch.setattr("w2w.core.selection.promise._better_chosen", lambda _: 1.0)
    promised, given = np.mean([world(0.1, seed) for seed in range(200)], axis=0)
    assert (promised < given - 0.006).any()


def test_where_nothing_repeats_nothing_is_gained():
    found = []
    for seed in range(80):
        rng = np.random.default_rng(seed)
        halves = tuple(Measured(np.full(PATCHES, 0.5), 0.05, rng) for _ in range(2))
        plan = SimpleNamespace(disjoint=True, shrink=4.0)
        tests = SimpleNamespace(
            whole=halves[0], pairs=(halves,), plan=plan, seed=seed, weights=np.ones(1), most_shown=1.0
        )
        promises, order = Promises(tests, FREE), best_first(halves[0], None, K)
        found.append(promises.of(order, best_first, (0.5, 0.0, 1.0)).mean[1:])
    np.testing.assert_allclose(
        np.mean(found, axis=0), reached(np.full(PATCHES, 0.5), range(K))[1:], atol=0.01
    )


def test_subjects_left_out_one_at_a_time_say_nothing_of_a_better_choice():
    """Their gain is believed by half, as their trainings share subjects."""
    level = reached(np.full(PATCHES, 0.5), range(K))[1:].mean()
    alone, halves = (np.mean([world(0.1, seed, kind)[0] for seed in range(50)]) for kind in (False, True))
    assert alone - level < 0.6 * (halves - level)


def test_a_set_takes_in_no_luck_of_the_sizes_before_it():
    np.testing.assert_allclose(rising(np.array([0.5, 0.4, 0.7, 0.6])), [0.5, 0.5, 0.65, 0.65])
    np.testing.assert_array_equal(rising(np.array([0.3])), [0.3])


@pytest.fixture(scope="module")
def tests():
    return prepare(*library())


def test_random_sets_are_tested_once_for_all_that_is_chosen_under_the_same_terms(tests, monkeypatch):
    promises, expected = Promises(tests, terms(3)), (0.5, 0.4, 0.54)
    promises.of([0, 4, 1], ByHalves(), expected)
    tested = []
    f1_of_firsts = type(tests.whole).f1_of_firsts

    def f1_of_firsts_told(one, orders, sizes):
        tested.extend(orders)
        return f1_of_firsts(one, orders, sizes)

    monkeypatch.setattr(type(tests.whole), "f1_of_firsts", f1_of_firsts_told)
    again = promises.of([0, 4], ByHalves(), expected)
    assert len(tested) == 1 + 2 * len(tests.pairs)  # the set itself, and each half's choice
    assert len(again.mean) == 2


@pytest.mark.parametrize("required", [(), ([10, 11], [4, 5])])
def test_random_sets_that_grow_are_as_good_as_larger_ones_from_the_start(tests, required):
    promises, anew = (Promises(tests, terms(4, required=required)) for _ in range(2))
    promises.level(tests.whole, 1)
    np.testing.assert_array_equal(promises.level(tests.whole, 4), anew.level(tests.whole, 4))


def test_clips_that_cannot_be_halved_are_said_to_tell_nothing():
    features, names, clip = library()
    few = np.isin(clip % 12, [0, 1, 2])
    found = prepare(features[few], names[few], clip[few])
    assert not found.pairs
    made = Promises(found, terms(2)).of([0, 4], ByHalves(), (0.5, 0.4, 0.6))
    assert not made.known
    assert (made.low[-1], made.high[-1]) == (0, 1)
    assert "cannot be compared" in made.text()


@pytest.mark.parametrize(
    ("whole", "half", "promised_f1"), [(0.5, 0.4, 0.54), (0.98, 0.9, 0.98 + 0.04 * 0.0196 / 0.09)]
)
def test_less_is_gained_where_less_is_left(whole, half, promised_f1):
    """Halves gain .04 over random sets; on all clips these are as good as they can be, or are not."""

    class Judged:
        single = np.arange(9.0)  # what is chosen by repeats

        def __init__(self, level, f1):
            self.level, self.f1 = level, f1

        def f1_of_first(self, _):
            return np.full((2, 4), self.f1)

        def f1_of_firsts(self, orders, _):
            return np.full((len(orders), 2, 4), self.level)

    one, other = Judged(half, half + 0.04), Judged(half, half + 0.04)
    plan = SimpleNamespace(disjoint=True, shrink=4.0)
    found = SimpleNamespace(
        whole=Judged(whole, 1.0), pairs=((one, other),), plan=plan, seed=0, weights=np.ones(4), most_shown=1.0
    )
    made = Promises(found, terms(2)).of([0, 4], lambda *_: [0, 4], (0.3, 0.2, 0.4))
    assert made.mean[1] == pytest.approx(promised_f1)
