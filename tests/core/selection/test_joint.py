# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen together: what complements is found, wishes are kept, the promise is what other clips give."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from w2w.core.ranking.stream import StreamF1
from w2w.core.ranking.utility import ExpectedF1
from w2w.core.selection import joint, set_tests
from w2w.core.selection.constraints import Terms
from w2w.core.selection.headline import short
from w2w.core.selection.joint import ByHalves, GrownSet, choose_together
from w2w.core.selection.promise import Promises, promise_in_stream

from .made_sets import CLIPS, NAMES, D, N, alone, library, prepare, terms

pytestmark = pytest.mark.later


def grown(found, under, **how):
    return GrownSet(found, under, found.single, **how)


@pytest.fixture(scope="module")
def tests():
    return prepare(*library())


def test_the_second_patch_tells_what_the_first_cannot(tests):
    order = grown(tests.whole, terms(2)).up_to(2)
    assert sorted(patch // 4 for patch in order) == [0, 1]


class Judged:
    """Tests that give each candidate a value by number, whatever is worn."""

    def __init__(self, values):
        self.values = np.array(values)

    def added(self, _worn, candidates, _worst):
        return self.values[candidates]


@given(st.integers(0, 2**32 - 1))
def test_a_hairs_breadth_does_not_decide_between_patches_that_do_alike(seed):
    breadth = np.random.default_rng(seed).uniform(-5e-4, 5e-4, 6)
    values = np.array([0.961, 0.9635, 0.955, 0.964, 0.9, 0.9635]) + breadth
    under = Terms(np.ones(6, bool), [], np.ones(6), 3, rarity=np.array([4, 1, 0, 2, 3, 5]))
    assert GrownSet(Judged(values), under, values).up_to(3) == (1, 3, 0)
    dear = replace(under, price=np.array([1.0, 1.001, 1, 1, 1, 1]))
    assert GrownSet(Judged(values), dear, values).up_to(3) == (3, 0, 5)  # of what does alike, the cheaper
    plain = GrownSet(Judged(values), replace(under, rarity=None), values).up_to(1)
    assert plain == (int(values.argmax()),)


@pytest.mark.slow
def test_the_promise_never_falls_and_stops_where_it_rises_no_more(tests):
    chosen = choose_together(tests, alone(tests), terms(4), target=1.0)
    assert (np.diff(chosen.promise.mean) > 0).all()
    assert 2 <= len(chosen.order) <= 4
    assert not chosen.reached
    assert (chosen.promise.low <= chosen.promise.mean).all()
    assert (chosen.promise.mean <= chosen.promise.high).all()


@pytest.mark.slow
def test_each_sensor_is_worth_its_while_where_the_target_is_out_of_reach(tests, monkeypatch):
    monkeypatch.setattr(joint, "WORTH", 0.1)
    chosen = choose_together(tests, alone(tests), terms(), target=1.0)
    tried = len(chosen.order) + len(chosen.further)
    assert (np.diff(chosen.promise.mean) >= 0.09).all()
    assert len(chosen.order) < tried
    assert chosen.most < chosen.promise.mean[-1] + 0.11
    assert f"no set of up to {tried} sensors reaches more than {short(chosen.most)}" in (chosen.sentence())


@pytest.mark.parametrize(
    ("f1", "delivered", "sensors"),
    [
        ([0.80, 0.81, 0.83], [0.7, 0.8, 0.9], 1),  # .03 for two sensors
        ([0.80, 0.81, 0.85], [0.7, 0.8, 0.9], 3),  # the second is worth it with the third
        ([0.80, 0.83, 0.85], [0.7, 0.8, 0.9], 3),
        ([0.80, 0.83, 0.85], [0.7, 0.715, 0.74], 3),  # .02 and .04 as shown
        ([0.80, 0.83, 0.85], [0.7, 0.714, 0.73], 1),  # halves added less
        ([0.58, 0.62, 0.64], [0.58, 0.58, 0.58], 1),
        ([0.66, 0.67, 0.67], [0.5, 0.6, 0.7], 1),
        ([0.80, 0.8951, 0.93], [0.7, 0.8, 0.9], 2),  # reaches the target as shown
        ([0.80, 0.8949, 0.93], [0.7, 0.8, 0.9], 3),
        ([0.88, 0.8949, 0.90], [0.7, 0.8, 0.9], 1),
    ],
)
def test_a_further_sensor_adds_two_hundredths_as_expected_and_as_delivered(f1, delivered, sensors):
    lacks = 0.9 - np.round(f1, 2)
    halves = np.array([delivered, delivered, np.sort(delivered)[::-1]])
    assert joint._enough(1, lacks, halves) == sensors
    assert joint._enough(1, lacks, np.empty((0, 3))) == 1  # nothing is shown


class Lossy:
    """A stream in which F1 of a set is so much lower."""

    def __init__(self, loss):
        self.loss = loss

    def losing(self, sets):
        return [StreamF1(np.full(len(NAMES), 0.9), np.full((2, len(NAMES)), 0.9 - self.loss)) for _ in sets]

    @property
    def lost(self):
        return np.full(len(NAMES), self.loss)

    def expected(self, _worn, by_clip):
        return ExpectedF1(by_clip.mean - self.loss, by_clip.low - self.loss, by_clip.high - self.loss)


@pytest.mark.slow
def test_a_target_is_reached_in_a_stream_or_not_at_all(tests):
    plain = choose_together(tests, alone(tests), terms(4), target=0.3)
    lossless, lossy = (
        choose_together(tests, alone(tests), terms(4), 0.3, stream=Lossy(loss)) for loss in (0.0, 0.2)
    )
    assert plain.promise.mean[0] == pytest.approx(lossless.promise.mean[0])
    assert plain.sentence() == lossless.sentence()
    assert lossy.promise.mean[0] == pytest.approx(lossless.promise.mean[0])  # in the stream as given
    never = choose_together(tests, alone(tests), terms(4), 0.85, stream=Lossy(0.5))
    assert not never.reached


def test_a_promise_in_a_stream_never_falls_though_the_stream_does(tests):
    order = grown(tests.whole, terms(3)).up_to(3)
    made = Promises(tests, terms(3)).of(order, ByHalves(), ExpectedF1(*(v[order[0]] for v in alone(tests))))
    stream = Lossy(0.0)
    stream.expected = lambda worn, by_clip: ExpectedF1(0.8 - 0.1 * len(worn), 0.1, by_clip.high)
    found = promise_in_stream(stream, order, made, ExpectedF1(0.7, 0.6, 0.8))
    assert (np.diff(found.mean) >= 0).all()
    assert found.mean[0] == pytest.approx(0.7)


def test_the_smallest_set_that_reaches_the_target_is_taken(tests):
    chosen = choose_together(tests, alone(tests), terms(2), target=0.3)
    assert chosen.reached
    assert len(chosen.order) == 1
    for found, told in zip((chosen.promise.mean, chosen.promise.low), alone(tests), strict=False):
        assert found[0] == pytest.approx(told[chosen.order[0]])


@pytest.mark.slow
def test_what_goes_best_with_a_set_that_is_enough_is_told(tests):
    wished = terms(2, required=[[10]])
    chosen = choose_together(tests, alone(tests), wished, target=0.01)
    assert chosen.order == (10,)
    both = (10, *chosen.further)
    assert both == GrownSet(tests.whole, wished, alone(tests)[0]).up_to(2)
    expected = Promises(tests, wished).of(both, ByHalves(), tuple(v[10] for v in alone(tests)))
    np.testing.assert_allclose(chosen.with_next.mean, expected.mean)
    assert chosen.with_next.mean[-1] > chosen.promise.mean[-1]
    assert choose_together(tests, alone(tests), terms(1, required=[[10]]), target=0.01).with_next is None


def test_every_activity_must_reach_what_is_asked_of_every_one(tests):
    least = choose_together(tests, alone(tests), terms(4), target=0.3, every_activity=0.5)
    assert len(least.order) > 1
    assert least.promise.f1[-1].min() >= 0.5 or not least.reached


def test_wishes_are_kept(tests):
    allowed = np.arange(N) != 5
    wished = terms(3, allowed=allowed, required=[[10, 11], [4, 5]])
    chosen = choose_together(tests, alone(tests), wished, target=0.3)
    assert 5 not in chosen.order
    assert np.isin(chosen.order, [10, 11]).any()
    assert 4 in chosen.order
    dear = np.ones(N)
    dear[:4] = 1e6
    assert grown(tests.whole, terms(1, cost=dear)).up_to(1)[0] >= 4


@pytest.mark.slow
def test_a_further_wish_finds_what_it_would_find_first_and_searches_without_wishes_once(tests, monkeypatch):
    fresh = prepare(*library())
    one, other = (replace(terms(2, allowed=np.arange(N) != left), unwished=terms(2)) for left in (0, 5))
    choose_together(fresh, alone(tests), one, target=1.0)
    joint.grow_unwished(fresh)
    assert [len(search.up_to(6)[0]) for search in fresh.searches.values()] == [terms(2).max_size]
    begun = []
    search = joint._Search.__init__
    monkeypatch.setattr(
        joint._Search, "__init__", lambda self, *how: (begun.append(how), search(self, *how))[1]
    )
    found = choose_together(fresh, alone(tests), other, target=1.0)
    assert len(begun) == 1
    first = choose_together(prepare(*library()), alone(tests), other, target=1.0)
    assert found.order == first.order
    assert found.sentence() == first.sentence()
    np.testing.assert_array_equal(found.promise.mean, first.promise.mean)


@pytest.mark.slow
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    forbidden=st.sets(st.integers(0, N - 1), max_size=N - 4),
    required=st.lists(st.integers(0, N - 1), max_size=2, unique=True),
    dear=st.sets(st.integers(0, N - 1), max_size=4),
)
def test_no_wish_promises_more(tests, forbidden, required, dear):
    allowed = ~np.isin(np.arange(N), list(forbidden - set(required)))
    cost = np.where(np.isin(np.arange(N), list(dear)), 3.0, 1.0)
    wished = terms(2, allowed=allowed, required=[[one] for one in required], cost=cost)
    expected = alone(tests)
    given = joint._Given(expected, False, None, expected[0])
    free = joint._Search(tests, terms(2), given).up_to(2)[1]
    chosen = choose_together(tests, expected, replace(wished, unwished=terms(2)), target=1.0)
    most = np.maximum(free.mean[: len(chosen.order)], expected[0][chosen.order[0]])
    assert (chosen.promise.mean <= most + 1e-9).all()
    assert (chosen.promise.low <= chosen.promise.mean).all()


@pytest.mark.slow
def test_the_promise_is_what_another_library_of_the_kind_gives():
    differences = []
    for seed in range(4):
        here, there = prepare(*library(2 * seed)), prepare(*library(2 * seed + 1))
        order = grown(here.whole, terms(2)).up_to(2)
        made = Promises(here, terms(2)).of(order, ByHalves(), (0.3, 0.2, 0.4))
        differences.append(made.mean[1] - there.whole.f1_of_first(order)[1].mean())
        assert made.raw.shape == (2, 4)
        np.testing.assert_allclose(made.f1.mean(axis=1), made.mean, atol=0.01)
    assert abs(np.mean(differences)) < 0.05


@pytest.mark.slow
def test_where_labels_mean_nothing_nothing_is_promised():
    promised = []
    for seed in range(4):
        found = prepare(*library(seed, shuffled=True))
        order = grown(found.whole, terms(3)).up_to(3)
        made = Promises(found, terms(3)).of(order, ByHalves(), (0.25, 0.2, 0.3))
        promised.append(made.f1[-1].mean())
    assert np.mean(promised) < 0.32  # a quarter is chance


def test_subjects_are_left_out_where_they_are_told():
    features, names, clip = library()
    subject = np.array(["a", "b", "c"])[clip % 3]
    found = prepare(features, names, clip, subject)
    assert not found.plan.disjoint
    chosen = choose_together(found, alone(found), terms(3), target=1.0)
    assert len(chosen.order) >= 2


def test_many_windows_are_thinned_evenly(monkeypatch):
    monkeypatch.setattr(set_tests, "MOST_WINDOWS", 64)
    features, names, clip = library()
    found = prepare(features, names, clip)
    assert len(found.whole.f1_of_first([0])) == 1
    assert sum(len(split.tested) for split in found.plan.splits[:3]) == 64
    chosen = choose_together(found, alone(found), terms(2), target=1.0)
    assert sorted(patch // 4 for patch in chosen.order) == [0, 1]


@pytest.mark.slow
def test_the_same_seed_chooses_and_promises_the_same(tests):
    again = prepare(*library())
    one, two = (choose_together(found, alone(found), terms(2), 1.0) for found in (tests, again))
    assert one.order == two.order
    np.testing.assert_array_equal(one.promise.mean, two.promise.mean)


def test_a_half_goes_on_where_it_stopped_and_ends_as_if_it_had_not(tests):
    (half, _), free = tests.pairs[0], terms(cost=np.linspace(1, 3, N))
    scratch = grown(half, free, among=joint.OF_HALVES).up_to(4)
    choose = ByHalves()
    assert choose(half, free, 2) == scratch[:2]
    assert choose(half, free, 4) == scratch
    assert choose(half, free, 3) == scratch[:3]


def test_from_the_third_patch_on_those_are_tried_that_were_best_for_the_one_before(tests, monkeypatch):
    monkeypatch.setattr(joint, "SHORTLIST", 0.6)
    monkeypatch.setattr(joint, "LEAST_LISTED", 3)
    added, tried = type(tests.whole).added, []

    def added_told(one, worn, candidates, worst):
        values = added(one, worn, candidates, worst)
        tried.append((candidates.tolist(), values))
        return values

    monkeypatch.setattr(type(tests.whole), "added", added_told)
    required = grown(tests.whole, terms(2, required=[[0], [11]]))
    required.up_to(2)
    assert len(required.candidates) == N  # of required ones there is no choice
    tried.clear()
    order = grown(tests.whole, terms(5)).up_to(5)
    assert len(tried[0][0]) == N - 1
    for size, (before, after) in enumerate(pairwise(tried), start=2):
        candidates, values = before
        best = np.array(candidates)[np.argsort(-values)[: max(int(0.6 * len(candidates)), 3)]]
        assert set(after[0]) == set(best.tolist()) - set(order[:size])
    assert [len(candidates) for candidates, _ in tried] == [11, 5, 2, 1]
    by_worst = grown(tests.whole, terms(4), worst=True)
    by_worst.up_to(4)
    assert len(by_worst.candidates) == N  # another activity is the worst each time
    assert {0, 9, 10} <= set(grown(tests.whole, terms(5, required=[[0], [9], [10]])).up_to(5))


def test_only_what_counts_decides_the_set_and_its_promise():
    """Patches 0 to 3 tell crawl from jump: where these are background, they are of no use."""
    made = library()
    both, background = prepare(*made), prepare(*made, counts={"crawl": 0.0, "jump": 0.0})
    assert set(grown(both.whole, terms(2)).up_to(2)) & {0, 1, 2, 3}
    counted = background.weights > 0
    np.testing.assert_array_equal(counted, [name in ("run", "sit") for name in background.activities])
    found = choose_together(background, alone(background), terms(3), 1.0)
    assert found.order[0] in (4, 5, 6, 7)
    np.testing.assert_allclose(found.promise.mean, found.promise.f1[:, counted].mean(axis=1), atol=0.02)
    np.testing.assert_allclose(found.raw_mean, found.promise.raw[:, counted].mean(axis=1))
    least = float(found.promise.f1[0][counted].min()) - 0.01
    assert found.promise.f1[0][~counted].min() < least  # and yet it is reached
    again = choose_together(background, alone(background), terms(3), 0.3, every_activity=least)
    assert again.reached
    assert not {"crawl", "jump"} & set(again.sentence().split())


@pytest.mark.slow
def test_no_weights_and_equal_weights_promise_the_same():
    made = library()
    one, other = (
        choose_together(found, alone(found), terms(2), 0.99)
        for found in (prepare(*made), prepare(*made, counts=dict.fromkeys(NAMES, 2.0)))
    )
    assert one.order == other.order
    np.testing.assert_array_equal(one.promise.mean, other.promise.mean)
    np.testing.assert_array_equal(one.promise.low, other.promise.low)


def test_a_set_that_is_never_wrong_is_no_surer_than_so_many_clips_can_show():
    rng = np.random.default_rng(3)
    clip = np.repeat(np.arange(4 * CLIPS), 2)
    features = rng.normal(size=(len(clip), N, D)).astype(np.float32)
    activity = np.repeat(np.arange(4), 2 * CLIPS)
    features[:, :, :4] += 60 * np.eye(4, dtype=np.float32)[activity][:, None]
    tests = prepare(features, np.array(NAMES)[activity], clip)
    found = Promises(tests, terms(3)).of((0, 5, 9), ByHalves(), (1.0, 0.9, 1.0))
    assert found.mean[1:] == pytest.approx(1.0)
    assert found.high[1:] == pytest.approx(1.0)
    assert found.low[1:] == pytest.approx(0.025 ** (1 / (4 * CLIPS)))  # Clopper and Pearson
