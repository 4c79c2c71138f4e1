# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparing places: who is better, by how much, and when nobody can tell."""

import numpy as np
import pytest

from w2w.core.library.library import Clip, Library
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.placements.activity_groups import PAPER_GROUPS, choose_activities
from w2w_studies.placements.comparison import compare_patches

GOOD, SAME, BAD = 0, 1, 2


@pytest.fixture(scope="module")
def utility():
    """A place that tells all three activities, one that does as well on other noise, one that guesses."""
    rng = np.random.default_rng(2)
    activity = np.repeat(["lift", "sit", "walk"], 120)
    clip = np.array([f"{name}{number // 4}" for number, name in enumerate(activity)])
    features = rng.normal(size=(len(activity), 3, 3)).astype(np.float32)
    for number, name in enumerate(("lift", "sit", "walk")):
        features[activity == name, :2, number] += 2.2
    return utility_map(
        features, CrossValidation(activity, clip, None, np.ones(360, bool), ["lift", "sit", "walk"], seed=1)
    )


def test_a_better_place_is_told_from_a_worse_one_and_not_from_its_equal(utility):
    found = compare_patches(utility, [GOOD], [SAME, BAD])
    np.testing.assert_array_equal(found.verdicts(), [[0, 1]])
    np.testing.assert_array_equal(compare_patches(utility, [BAD], [GOOD]).verdicts(), [[-1]])
    np.testing.assert_allclose(found.f1, utility.mean[[GOOD]], atol=1e-6)
    np.testing.assert_allclose(found.other_f1, utility.mean[[SAME, BAD]], atol=1e-6)
    assert (found.low <= found.difference).all()
    assert (found.difference <= found.high).all()


def test_a_place_does_not_differ_from_itself(utility):
    found = compare_patches(utility, [SAME], [SAME])
    assert found.low == found.high == found.difference == 0


def test_the_interval_turns_round_with_the_question(utility):
    one, other = compare_patches(utility, [GOOD], [SAME]), compare_patches(utility, [SAME], [GOOD])
    np.testing.assert_allclose(one.low, -other.high, atol=1e-6)
    np.testing.assert_allclose(one.difference, -other.difference, atol=1e-6)


def test_some_activities_alone(utility):
    found = compare_patches(utility, [GOOD], [BAD], ["sit"])
    assert found.f1[0] == pytest.approx(utility.f1[GOOD, 1], abs=1e-6)
    with pytest.raises(ValueError, match="none of these activities was tested: fly"):
        compare_patches(utility, [GOOD], [BAD], ["fly"])


def clips(**motions):
    """Clips of activities; `motions` gives the motion keys of each."""
    made = [
        Clip(f"{name}{number}.fbx", f"{name}{number}.fbx", f"{name}{number}", name, "", key)
        for name, keys in motions.items()
        for number, key in enumerate(keys)
    ]
    return Library(".", tuple(made), "a test")


def test_activities_with_the_most_motions_stand_for_a_group():
    library = clips(a="xyz", b="xy", c="xx", d="wxyz", e=["", "", ""], f="xy")
    group_of = dict.fromkeys("abcde", PAPER_GROUPS[1]) | {"f": "other"}
    chosen = choose_activities(library, group_of, 3)
    assert chosen[PAPER_GROUPS[1]] == ("a", "d", "e")  # c shows one motion twice
    assert [len(names) for names in chosen.values()] == [0, 3, 0, 0, 0, 0]
    assert choose_activities(library, group_of, 9)[PAPER_GROUPS[1]] == ("a", "b", "d", "e")


def test_a_library_without_the_groups_is_refused():
    with pytest.raises(ValueError, match="balance_intensive"):
        choose_activities(clips(a="xy", b="xy"), {"a": PAPER_GROUPS[0], "b": "other"})
