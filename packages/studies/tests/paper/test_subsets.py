# SPDX-License-Identifier: GPL-3.0-or-later
"""Greedy and exact choice of places, against every choice tried, and a designer's constraints."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from w2w.core.patches.body_parts import patches_named
from w2w_studies.paper.subsets import exact_subset, greedy_subset

MAPS = arrays(
    np.float64,
    st.tuples(st.integers(2, 8), st.integers(1, 5)),
    elements=st.integers(0, 100).map(lambda n: n / 100),
)


def mean_max(f1, places):
    return f1[list(places)].max(axis=0).mean()


def every_subset(n_places, max_size):
    return [s for size in range(1, max_size + 1) for s in combinations(range(n_places), size)]


def trap():
    """Greedy takes the all-rounder first and then needs three; two specialists do."""
    return np.array([[0.7, 0.7, 0.7, 0.7], [1.0, 1.0, 0.2, 0.2], [0.2, 0.2, 1.0, 1.0]])


def test_greedy_falls_into_the_trap_and_exact_does_not():
    greedy, exact = greedy_subset(trap(), 0.95), exact_subset(trap(), 0.95)
    assert greedy.order == (0, 1, 2)
    np.testing.assert_allclose(greedy.mean_max_after_each, [0.7, 0.85, 1.0])
    assert sorted(exact.order) == [1, 2]
    assert exact.proven
    assert exact.cost == 2
    assert not greedy.proven


@settings(deadline=None, max_examples=60)
@given(f1=MAPS, target=st.sampled_from([0.3, 0.6, 0.8, 0.9]))
def test_exact_is_as_small_and_as_good_as_any_set(f1, target):
    result = exact_subset(f1, target)
    reaching = [s for s in every_subset(len(f1), len(f1)) if mean_max(f1, s) >= target - 1e-6]
    assert result.reached == bool(reaching)
    if reaching:
        smallest = min(len(s) for s in reaching)
        assert len(result.order) == smallest
        best = max(mean_max(f1, s) for s in reaching if len(s) == smallest)
    else:
        best = f1.max(axis=0).mean()
    assert result.mean_max_after_each[-1] == pytest.approx(best, abs=1e-5)
    assert mean_max(f1, result.order) == pytest.approx(result.mean_max_after_each[-1])


@settings(deadline=None, max_examples=60)
@given(f1=MAPS, target=st.sampled_from([0.3, 0.6, 0.9]))
def test_greedy_takes_the_greatest_gain_at_each_step(f1, target):
    result = greedy_subset(f1, target)
    assert len(set(result.order)) == len(result.order)
    for size, value in enumerate(result.mean_max_after_each):
        before = result.order[:size]
        best = max(mean_max(f1, (*before, place)) for place in range(len(f1)))
        assert value == pytest.approx(best)
        assert value == pytest.approx(mean_max(f1, result.order[: size + 1]))
    assert result.best_reachable == pytest.approx(f1.max(axis=0).mean())
    assert result.reached == (result.mean_max_after_each[-1] >= target - 1e-6)
    if not result.reached:
        assert result.mean_max_after_each[-1] == pytest.approx(result.best_reachable)


@settings(deadline=None, max_examples=40)
@given(f1=MAPS, data=st.data())
def test_constraints_hold_in_both_and_exact_is_the_best_under_them(f1, data):
    n_places = len(f1)
    allowed = np.array(data.draw(st.lists(st.booleans(), min_size=n_places, max_size=n_places)))
    if not allowed.any():
        return
    group = data.draw(st.sets(st.sampled_from(np.flatnonzero(allowed).tolist()), min_size=1))
    size = data.draw(st.integers(1, n_places))
    constraints = {"max_size": size, "allowed": allowed, "required": [sorted(group)]}
    exact = exact_subset(f1, 2.0, **constraints)
    for result in (greedy_subset(f1, 2.0, **constraints), exact):
        assert allowed[list(result.order)].all()
        assert group & set(result.order)
        assert len(result.order) <= size
        assert not result.reached
    permitted = [s for s in every_subset(n_places, size) if allowed[list(s)].all() and group & set(s)]
    assert exact.mean_max_after_each[-1] == pytest.approx(max(mean_max(f1, s) for s in permitted), abs=1e-5)


def test_costs_decide():
    f1 = np.array([[0.9, 0.9], [0.88, 0.88], [0.1, 0.95]])
    cost = np.array([5.0, 1.0, 1.0])
    assert greedy_subset(f1, 0.85).order == (0,)
    assert greedy_subset(f1, 0.85, cost=cost).order == (1,)
    exact = exact_subset(f1, 0.89, cost=cost)
    assert sorted(exact.order) == [1, 2]
    assert exact.cost == 2


def test_unreachable_target_says_the_best_reachable():
    result = greedy_subset(trap(), 0.95, allowed=np.array([True, True, False]))
    assert not result.reached
    assert result.sentence() == (
        "2 patches reach a mean-max F1 of 0.850; the target 0.95 is not reached, "
        "and all allowed patches together reach 0.850"
    )
    assert greedy_subset(trap(), 0.7).sentence() == "1 patch reaches a mean-max F1 of 0.700 (target 0.7)"


@pytest.mark.slow
def test_exact_solves_a_whole_body_in_seconds():
    """512 places of 24 activities, as smooth over the body as a real map."""
    rng = np.random.default_rng(1)
    f1 = 1 / (1 + np.exp(-0.9 - rng.normal(size=(512, 4)) @ rng.normal(size=(4, 24)) * 0.4))
    greedy = greedy_subset(f1, 0.87)
    exact = exact_subset(f1, 0.87, time_limit_s=60)
    assert exact.proven
    assert exact.reached
    assert len(exact.order) <= len(greedy.order)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"allowed": np.zeros(3, bool)}, "no patch is allowed"),
        ({"allowed": np.ones(4, bool)}, r"allowed must have shape \(3,\)"),
        ({"allowed": np.array([True, True, False]), "required": [2]}, r"\[2\] is required"),
        ({"required": [0, 1], "max_size": 1}, "2 patches are required"),
        ({"max_size": 0}, "max_size is 0"),
        ({"cost": np.array([1.0, 0.0, 1.0])}, "cost must hold 3 positive numbers"),
    ],
)
@pytest.mark.parametrize("choose", [greedy_subset, exact_subset])
def test_impossible_wishes_are_refused_in_words(choose, arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        choose(trap(), **arguments)


def test_places_are_found_by_the_words_of_their_region():
    regions = ("left wrist dorsal", "right wrist volar", "left thigh front", "lower spine")
    assert patches_named(regions, "wrist").tolist() == [0, 1]
    assert patches_named(regions, "Left wrist").tolist() == [0]
    assert patches_named(regions, "left").tolist() == [0, 2]
    with pytest.raises(
        ValueError, match="named 'elbow'; the regions are: left thigh front, left wrist dorsal"
    ):
        patches_named(regions, "elbow")


def test_the_first_of_equal_gains_is_chosen():
    f1 = np.array([[0.2, 0.2], [0.9, 0.1], [0.9, 0.1], [0.1, 0.9], [0.1, 0.9]])
    assert greedy_subset(f1, 0.9).order == (1, 3)
    # of several places one of which is required, the one named first
    assert greedy_subset(f1, 0.9, required=[[4, 2]]).order == (4, 1)
