# SPDX-License-Identifier: GPL-3.0-or-later
"""Advice on a ranking: the best spot, sensors to wear together, places that say the same, constraints."""

import numpy as np
import pytest

from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map
from w2w.core.selection.advice import advise
from w2w.core.selection.constraints import Constraints
from w2w.core.selection.scored import ScoredMap
from w2w.core.selection.set_tests import SetTests

ACTIVITIES = ("bow", "jump", "run", "walk")


@pytest.fixture(scope="module")
def patches(bundled_body):
    return sample_patches(bundled_body, 24, seed=0)


@pytest.fixture(scope="module")
def made(patches):
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
    return features.astype(np.float32), activity, clip, None, np.ones(160, bool), ACTIVITIES, 3


@pytest.fixture(scope="module")
def utility(made):
    return utility_map(made[0], CrossValidation(*made[1:]), resamples=20)


@pytest.fixture(scope="module")
def tests(made, patches):
    return SetTests.of(made[0], CrossValidation(*made[1:]), Pooling.none(len(patches)))


def side(patches, place):
    return patches.regions[place].split()[0]


@pytest.mark.slow
def test_a_left_and_a_right_place_do_it_together(utility, patches, bundled_body, tests):
    advice = advise(ScoredMap(utility, patches, bundled_body), tests, 0.97)
    order = advice.worn.order
    assert {side(patches, place) for place in order[:2]} == {"left", "right"}
    assert "95 % interval" in advice.worn.sentence()
    for place, others in zip(order, advice.alternatives, strict=True):
        assert place not in others
        assert {side(patches, other) for other in others} <= {side(patches, place)}
    assert any(len(others) for others in advice.alternatives)


@pytest.mark.later
def test_constraints_bind_the_best_the_set_and_the_next(utility, patches, bundled_body, tests):
    left, middle = Constraints(only=("left",)), Constraints(must=("middle",))
    advice = advise(ScoredMap(utility, patches, bundled_body), tests, 0.97, constraints=left, max_places=2)
    taken = [advice.best, *advice.worn.order, *advice.worn.further, *np.concatenate(advice.alternatives)]
    assert all(patches.regions[int(place)].startswith("left") for place in taken)
    forced = advise(ScoredMap(utility, patches, bundled_body), tests, 0.97, constraints=middle, max_places=2)
    assert any(not patches.regions[place].startswith(("left", "right")) for place in forced.worn.order)
    with pytest.raises(ValueError, match="2 patches are required"):
        advise(
            ScoredMap(utility, patches, bundled_body),
            tests,
            max_places=1,
            constraints=Constraints(must=("left", "right")),
        )


def test_without_tests_there_is_the_best_spot_alone(utility, patches, bundled_body):
    advice = advise(ScoredMap(utility, patches, bundled_body), None)
    assert (advice.worn, advice.alternatives) == (None, ())
    assert advice.best == utility.expected_mean.argmax()


@pytest.mark.slow
def test_a_set_from_few_clips_has_no_interval_beside_the_words_that_there_are_too_few(
    utility, patches, bundled_body, tests, monkeypatch
):
    few = "from at most 3 clips per activity: too few for an interval"
    monkeypatch.setattr("w2w.core.selection.advice.mean_caution", lambda _: few)
    worn = advise(ScoredMap(utility, patches, bundled_body), tests, 0.97).worn
    assert f"({few})" in worn.sentence()
    assert "95 %" not in worn.sentence()
