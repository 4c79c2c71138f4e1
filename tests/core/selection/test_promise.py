# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chosen set is promised to give is what it gives, over many made-up libraries."""

from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.selection.promise import promise, rising
from w2w.core.selection.terms import Terms

N, K = 60, 3
SPREAD = 0.05
"""Standard deviation of the patches' true F1."""


def reached(values, order):
    """F1 of the first patch, the first two, and so on."""
    return 0.5 + np.cumsum(values[list(order)] - 0.5 + 0.1) / K


class Measured:
    """Tests of some clips: a patch's true F1 and noise; each patch of a set adds its share, and some."""

    def __init__(self, truth, noise, rng):
        self.single = truth + noise * rng.normal(size=N)
        self.level = (None, np.empty((0, 1)))
        self.delivered = {}

    def f1_of_first(self, order):
        return reached(self.single, order)[:, None]

    def f1_of_firsts(self, orders, sizes):
        return np.array([self.f1_of_first(order)[np.array(sizes) - 1] for order in orders])


def best_first(tests, _terms, size):
    return (-tests.single).argsort()[:size]


def world(noise, seed, disjoint=True):
    """Promise of the set that a library chooses, and what the set truly gives."""
    rng = np.random.default_rng(seed)
    truth = 0.5 + SPREAD * rng.normal(size=N)
    halves = tuple(Measured(truth, noise * np.sqrt(2), rng) for _ in range(2))
    whole = Measured(truth, 0.0, rng)
    whole.single = (halves[0].single + halves[1].single) / 2
    plan = SimpleNamespace(disjoint=disjoint, shrink=4.0)
    tests = SimpleNamespace(whole=whole, pairs=(halves,), plan=plan, seed=seed, weights=np.ones(1))
    terms = Terms.checked(whole.single[:, None], K, None, (), None)
    order = best_first(whole, terms, K)
    made = promise(tests, terms, order, best_first, (0.0, 0.0, 1.0))
    return made.mean[1:], reached(truth, order)[1:]


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.1])
def test_all_clips_choose_better_than_the_halves_that_tell_of_it(noise):
    promised, given = np.mean([world(noise, seed) for seed in range(200)], axis=0)
    np.testing.assert_allclose(promised, given, atol=0.006)


def test_what_halves_gain_alone_would_be_too_little(monkeypatch):
    monkeypatch.setattr("w2w.core.selection.promise._better_chosen", lambda _: 1.0)
    promised, given = np.mean([world(0.1, seed) for seed in range(200)], axis=0)
    assert (promised < given - 0.006).any()


def test_where_nothing_repeats_nothing_is_gained():
    found = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        halves = tuple(Measured(np.full(N, 0.5), 0.05, rng) for _ in range(2))
        plan = SimpleNamespace(disjoint=True, shrink=4.0)
        tests = SimpleNamespace(whole=halves[0], pairs=(halves,), plan=plan, seed=seed, weights=np.ones(1))
        terms = Terms.checked(halves[0].single[:, None], K, None, (), None)
        order = best_first(halves[0], terms, K)
        found.append(promise(tests, terms, order, best_first, (0.5, 0.0, 1.0)).mean[1:])
    np.testing.assert_allclose(np.mean(found, axis=0), reached(np.full(N, 0.5), range(K))[1:], atol=0.01)


def test_subjects_left_out_one_at_a_time_say_nothing_of_a_better_choice():
    """Their gain is believed by half, as their trainings share subjects."""
    level = reached(np.full(N, 0.5), range(K))[1:].mean()
    alone, halves = (np.mean([world(0.1, seed, kind)[0] for seed in range(50)]) for kind in (False, True))
    assert alone - level < 0.6 * (halves - level)


def test_a_set_takes_in_no_luck_of_the_sizes_before_it():
    np.testing.assert_allclose(rising(np.array([0.5, 0.4, 0.7, 0.6])), [0.5, 0.5, 0.65, 0.65])
    np.testing.assert_array_equal(rising(np.array([0.3])), [0.3])
