# SPDX-License-Identifier: GPL-3.0-or-later
"""Advice on a ranking: greedy beside exact, one sensor more, places that say the same, constraints."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.utility import utility_map
from w2w.core.selection.advice import advise
from w2w.core.selection.constraints import Constraints

ACTIVITIES = ("bow", "jump", "run", "walk")


@pytest.fixture(scope="module")
def patches(bundled_body):
    return sample_patches(bundled_body, 24, seed=0, mode="fast")


@pytest.fixture(scope="module")
def utility(patches):
    """Left places tell bow and jump apart from the rest, right places run and walk, others little."""
    rng = np.random.default_rng(0)
    activity = np.repeat(ACTIVITIES, 40)
    clip = np.arange(160) // 4
    index = np.searchsorted(ACTIVITIES, activity)
    centres = rng.normal(size=(4, 8)) * 6
    side = np.array(
        [("left", "right").index(r.split()[0]) if r[:4] in ("left", "righ") else 2 for r in patches.regions]
    )
    features = rng.normal(size=(160, 3, 8))[:, side] + 0.2 * rng.normal(size=(160, len(patches), 8))
    for place, region in enumerate(patches.regions):
        if region.startswith("left"):
            features[:, place] += centres[np.where(index < 2, index, 2)]
        elif region.startswith("right"):
            features[:, place] += centres[np.where(index < 2, 0, index)]
    return utility_map(
        features.astype(np.float32), activity, clip, None, np.ones(160, bool), ACTIVITIES, resamples=200
    )


def test_a_left_and_a_right_place_do_it_together(utility, patches):
    advice = advise(utility, patches, 0.97)
    sides = {patches.regions[place].split()[0] for place in advice.subset.order}
    assert sides == {"left", "right"}
    assert advice.exact.proven
    assert len(advice.exact.order) == len(advice.subset.order) == 2
    assert "exact optimum" in advice.gap_sentence()
    assert 0 <= advice.next_gain < 0.03
    assert advice.next_patch not in advice.subset.order
    for place, others in zip(advice.subset.order, advice.alternatives, strict=True):
        assert place not in others
        assert {patches.regions[other].split()[0] for other in others} <= {patches.regions[place].split()[0]}
    assert any(len(others) for others in advice.alternatives)


def test_constraints_bind_the_best_the_set_and_the_next(utility, patches):
    advice = advise(utility, patches, 0.97, constraints=Constraints(only=("left",)))
    taken = [advice.best, *advice.subset.order, *advice.exact.order, *np.concatenate(advice.alternatives)]
    assert all(patches.regions[int(place)].startswith("left") for place in taken)
    assert not advice.subset.reached
    assert advice.subset.best_reachable < 0.9
    assert patches.regions[advice.next_patch].startswith("left")
    forced = advise(utility, patches, 0.97, constraints=Constraints(must=("middle",)))
    for order in (forced.subset.order, forced.exact.order):
        assert any(not patches.regions[place].startswith(("left", "right")) for place in order)
    with pytest.raises(ValueError, match="2 patches are required"):
        advise(utility, patches, 0.9, max_places=1, constraints=Constraints(must=("left", "right")))


def test_the_gap_is_said_in_words(utility, patches):
    dear = Constraints(costs=(("left", 4.0), ("right", 4.0)))
    sides = [patches.regions[place].partition(" ")[0] for place in range(len(patches))]
    f1 = np.full_like(utility.f1, 0.1)
    f1[sides.index("left"), :2] = f1[sides.index("right"), 2:] = 1.0
    middle = next(place for place, side in enumerate(sides) if side not in ("left", "right"))
    f1[middle] = 0.9  # cheap, and not enough
    advice = advise(replace(utility, f1=f1), patches, 0.97, constraints=dear)
    assert advice.exact.cost == 8.0
    assert advice.exact.proven
    assert advice.subset.cost > 8.0  # greedy takes what is cheap and says little first
    score = advice.exact.mean_max_after_each[-1]
    assert advice.gap_sentence() == (
        f"the exact optimum reaches {score:.3f} with 2 sensors at a cost of 8, "
        f"greedy needs {len(advice.subset.order)} sensors at a cost of {advice.subset.cost:g}"
    )


def test_how_many_places_it_takes_to_have_one_wherever_one_must_be(utility, patches):
    must = Constraints(must=("left arm", "right leg"))
    advice = advise(utility, patches, 0.99, None, must)
    required = must.terms(patches)["required"]
    order = list(advice.subset.order)
    for places in required:
        assert set(order[: advice.least]) & set(places.tolist())
    assert not all(set(order[: advice.least - 1]) & set(places.tolist()) for places in required)
    assert advise(utility, patches, 0.99).least == 1
