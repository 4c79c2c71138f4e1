# SPDX-License-Identifier: GPL-3.0-or-later
"""Costs: their interval holds what other clips show, and doing as well means at most .02."""

from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.ranking.costs import MOMENT, Cost, cost_of, gain, is_as_good
from w2w.core.ranking.expected import expect
from w2w.core.ranking.halves import plan
from w2w.core.ranking.pooling import Pooling

N, A = 60, 5


def scored(found, doubtful=False):
    """What a cost is taken from."""
    halved = len(found.errors) > 0
    return SimpleNamespace(**vars(found), level=0.95, halved=halved, doubtful=doubtful)


def world(seed, people=None, alike=0.8):
    """A map of places of which half move together, what other clips show of it, and what is true."""
    rng = np.random.default_rng(seed)
    if people is None:
        clip = np.repeat(np.arange(A * 40), 2)
        work = plan(clip % A, clip, clip // A % 5, np.ones(len(clip), bool), seed=seed)
    else:
        clip = np.repeat(np.arange(A * people * 4), 2)
        fold = clip // A % people
        work = plan(clip % A, clip, fold, np.ones(len(clip), bool), by_subject=True, seed=seed)
    truth = np.repeat(0.5 + 0.05 * rng.normal(size=(1, N)), A, axis=0)
    together = np.arange(N) < N // 2

    def shown(scale):
        common = rng.normal(size=(A, 1)) * together
        return truth + 0.06 * scale * (alike * common + np.sqrt(1 - alike**2) * rng.normal(size=(A, N)))

    single = 1.0 if not work.disjoint else np.sqrt(2)
    trials = {trial: shown(single if work.disjoint else np.sqrt(people)) for trial in work.trials[1:]}
    if work.disjoint:
        halves = [[shown(np.sqrt(2)) for _ in pair] for pair in work.pairs]
        trials = {
            trial: one
            for pair, two in zip(work.pairs, halves, strict=True)
            for trial, one in zip(pair, two, strict=True)
        }
        whole = np.mean(halves[0], axis=0)
    else:
        whole = np.mean(list(trials.values()), axis=0)
    maps = np.stack([whole, *(trials[trial] for trial in work.trials[1:])])
    return expect(maps, work, Pooling.none(N), 0.95), shown(1.0).mean(axis=0), truth.mean(axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("people", [None, 8])
def test_the_interval_of_a_cost_holds_what_other_clips_show(people):
    held, true = [], []
    for seed in range(40):
        found, other, truth = world(seed, people)
        utility, best = scored(found), int(found.expected_mean.argmax())
        for place in range(0, N, 3):
            if place != best:
                one = cost_of(utility, [best], [place])
                held.append(one.low <= other[best] - other[place] <= one.high)
                true.append(one.low <= truth[best] - truth[place] <= one.high)
    assert 0.9 <= np.mean(held) <= 0.98
    assert np.mean(true) > np.mean(held)


def test_places_that_move_together_have_a_narrower_interval():
    widths = np.zeros(2)
    for seed in range(5):
        utility = scored(world(seed, alike=0.95)[0])
        for number, place in enumerate((1, N - 1)):
            one = cost_of(utility, [0], [place])
            widths[number] += one.high - one.low
    assert widths[0] < 0.9 * widths[1]


def test_a_place_costs_nothing_against_itself_and_what_drawn_libraries_show_where_nothing_was_halved():
    utility = scored(world(0)[0])
    assert cost_of(utility, [3, 4], (3, 4))[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    unknown = cost_of(SimpleNamespace(**{**vars(utility), "halved": False}), [0], [1])
    assert unknown.high - unknown.low == pytest.approx(2 * 1.96 * 0.1, abs=1e-3)


def test_two_digits_decide_as_they_are_shown():
    costs = np.array([-0.3, 0.0, 0.02, 0.0249, 0.0251, 0.3])
    assert is_as_good(costs).tolist() == [True, True, True, True, False, False]


def test_a_cost_whose_interval_holds_zero_is_not_shown():
    assert Cost(0.3, 0.1, 0.5).verdict() == ""
    assert Cost(0.3, -0.1, 0.7).verdict() == "may cost"
    assert Cost(0.01, -0.1, 0.12).verdict() == "as good"


def test_errors_of_people_and_of_few_clips_are_wider_than_halves_show():
    found = world(0)[0]
    sure, doubtful = (cost_of(scored(found, doubtful), [0], [1]) for doubtful in (False, True))
    assert doubtful.high - doubtful.expected == pytest.approx(1.4 * (sure.high - sure.expected))


def test_a_large_lead_can_be_counted_on_and_a_small_one_hardly():
    found = world(0)[0]
    expected = np.full(N, 0.3, dtype=np.float32)
    expected[0], expected[1] = 0.9, 0.31
    utility = scored(SimpleNamespace(**{**vars(found), "expected_mean": expected}))
    large, small = gain(utility, [0], [2]), gain(utility, [1], [2])
    assert large.expected == pytest.approx(0.6, abs=0.01)
    assert large.low > MOMENT
    assert 0 < small.expected < 0.0099
    assert small.low < 0
    assert gain(utility, [2], [2]) == (0, 0, 0)
    people = gain(scored(SimpleNamespace(**{**vars(found), "expected_mean": expected}), True), [1], [2])
    assert people.expected < small.expected
