# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a ranking: a patch where one stands out, parts of the body where many are as good."""

from dataclasses import fields, replace

import numpy as np
import pytest

from w2w.core.patches.body_parts import ALL, great_part, segment
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.headline import (
    BELOW_AVERAGE,
    CANNOT_RANK,
    WORN,
    as_good_as,
    best_spot_sentence,
    confidence_sentence,
    mean_caution,
    more_clips,
    spot_caution,
)


@pytest.fixture(scope="module")
def patches(bundled_body):
    return sample_patches(bundled_body, 256, seed=0)


def ranked(expected, as_good, reliability=0.8, clips=12, protocol="5-fold cross-validation grouped by clip"):
    """A ranking of which only what is said matters, of two activities."""
    expected = np.asarray(expected, dtype=np.float32)
    given = dict.fromkeys((field.name for field in fields(UtilityMap)), np.zeros(0))
    given |= {
        "expected_mean": expected,
        "expected_low": expected - 0.0625,
        "expected_high": expected + 0.0625,
        "as_good": np.asarray(as_good, dtype=bool),
        "reliability": reliability,
        "beats_average": 0.93,
        "can_rank": True,
        "activities": ("sit", "walk"),
        "truth": np.repeat([0, 1], clips),
        "clip": np.array([f"clip {number}" for number in range(2 * clips)]),
        "protocol": protocol,
    }
    return UtilityMap(**given)


def where(patches, *parts):
    return np.array([segment(region) in parts for region in patches.regions])


def scored(group, best):
    expected = np.where(group, 0.75, 0.5)
    expected[best] = 0.84
    return expected


def test_one_patch_is_named_where_it_stands_out(patches):
    best = 17
    alone = np.arange(len(patches)) == best
    said = best_spot_sentence(best, ranked(scored(alone, best), alone), patches)
    name = patches.names[best]
    assert said == (
        f"{name[0].upper()}{name[1:]} (no other patch is as good), expected mean F1 .84 on other clips "
        "(95 % interval .78 to .90)"
    )


def test_a_group_is_named_by_the_parts_that_hold_it_the_highest_first(patches):
    group = where(patches, "right forearm", "right upper arm", "left upper arm")
    best = int(np.flatnonzero(where(patches, "right forearm"))[0])
    said = best_spot_sentence(best, ranked(scored(group, best), group), patches)
    assert said == (
        f"Right forearm and left and right upper arm ({group.sum()} patches are as good), "
        "expected mean F1 .84 on other clips (95 % interval .78 to .90)"
    )


def test_a_group_all_over_the_body_is_named_by_its_great_parts(patches):
    """Three small parts would hold less than half of it."""
    parts = ("left hand", "left forearm", "left upper arm", "right shoulder", "right thigh", "right knee")
    one_each = [int(np.flatnonzero(where(patches, part))[0]) for part in (*parts, "head", "sacrum")]
    group = np.isin(np.arange(len(patches)), one_each)
    said = best_spot_sentence(one_each[1], ranked(scored(group, one_each[1]), group), patches)
    assert said.startswith("Left and right arm, right leg and 2 other parts of the body (8 patches ")


def test_noise_that_changes_which_of_equals_is_highest_changes_no_part_named(patches):
    """Noise of a twentieth of the last digit shown, patch by patch."""
    group = where(patches, "left thigh", "right thigh", "left hand")
    rng, said = np.random.default_rng(0), set()
    for _ in range(20):
        expected = np.where(group, 0.842, 0.5) + rng.normal(scale=0.0005, size=len(patches))
        best = int(expected.argmax())
        said.add(best_spot_sentence(best, ranked(expected, group), patches))
    assert len(said) == 1


def test_where_all_are_as_good_no_part_is_named(patches):
    everywhere = np.ones(len(patches), dtype=bool)
    said = best_spot_sentence(3, ranked(scored(everywhere, 3), everywhere), patches)
    assert said.startswith("Anywhere on the body (all 256 patches are as good), expected mean F1 .84")
    left = where(patches, "left thigh")
    best = int(np.flatnonzero(left)[0])
    said = best_spot_sentence(best, ranked(scored(everywhere, best), everywhere), patches, left)
    assert said.startswith(f"Anywhere that is allowed (all {left.sum()} patches are as good)")


def test_constraints_that_leave_out_the_best_leave_out_its_equals(patches):
    """The best that is allowed is one of the group, or can be told from it: then it stands alone."""
    hand, thigh = where(patches, "right hand"), where(patches, "left thigh")
    best, top = int(np.flatnonzero(thigh)[0]), int(np.flatnonzero(hand)[0])
    expected = scored(hand, top)
    expected[best] = 0.7
    apart = ranked(expected, hand)
    assert as_good_as(best, apart, ~hand).tolist() == [best]
    assert "(the best patch anywhere would give .84), expected mean F1 .70" in best_spot_sentence(
        best, apart, patches, ~hand
    )
    among = ranked(expected, hand | thigh)
    assert as_good_as(best, among, ~hand).tolist() == np.flatnonzero(thigh).tolist()
    assert as_good_as(top, among).tolist() == np.flatnonzero(hand | thigh).tolist()


def test_subjects_foretell_people_and_too_few_clips_no_interval(patches):
    everywhere = np.ones(len(patches), dtype=bool)
    people = ranked(scored(everywhere, 3), everywhere, protocol="leave one of 5 subjects out")
    assert "expected mean F1 .84 on other people (95" in best_spot_sentence(3, people, patches)
    few = ranked(scored(everywhere, 3), everywhere, clips=3)
    assert mean_caution(few) == "from at most 3 clips per activity: too few for an interval"
    assert f"({mean_caution(few)})" in best_spot_sentence(3, few, patches)


@pytest.mark.parametrize(
    ("reliability", "clips", "sentence", "more"),
    [
        (0.75, 36, "F1 repeats at .75 (good from .85); about 32 more clips for each activity would", 32),
        (0.85 * 9 / (0.85 * 9 + 0.15 * 10), 9, "about 1 more clip for each activity would make it good", 1),
        (0.9, 12, "F1 repeats at .90 (good from .85)", 0),
        (0.3, 12, "more than 10 times as many clips would make it good", None),
        (-0.1, 12, "F1 repeats at -.10 (good from .85); more than 10 times", None),
    ],
)  # fmt: skip
def test_how_many_more_clips_would_do(reliability, clips, sentence, more):
    utility = ranked([0.5], [True], reliability, clips)
    assert sentence in confidence_sentence(utility)
    assert more_clips(utility) == more


def test_what_the_best_spot_gains_and_how_sure_that_is():
    utility = ranked([0.5, 0.7], [False, True], 0.9)
    said = confidence_sentence(utility)
    assert said.startswith(
        "The best spot beats an average one on other clips by about .10 (93 % sure). Patch"
    )
    assert said.endswith(f"came out {WORN[False]} (docs/truth.md)")
    certain = replace(utility, beats_average=1.0)
    assert "(99 % sure)" in confidence_sentence(certain)


def test_an_allowed_spot_that_promises_less_than_an_average_one_is_not_praised():
    utility = ranked([0.5, 0.7, 0.75], [False, True, True], 0.9)
    assert [spot_caution(best, utility) for best in range(3)] == [BELOW_AVERAGE, "", ""]
    assert spot_caution(0, replace(utility, can_rank=False)) == CANNOT_RANK
    assert confidence_sentence(utility, 0).startswith("The best spot anywhere beats an average one")
    assert confidence_sentence(utility, 2).startswith("The best spot beats")


def test_clips_that_cannot_be_halved_are_said_not_to_tell():
    utility = replace(ranked([0.5], [True], np.nan, 2), half_f1=None)
    assert confidence_sentence(utility).startswith("How sure this is cannot be told")


def test_of_subjects_it_says_how_many_times_as_many():
    utility = ranked([0.5], [True], 0.6, protocol="leave one of 5 subjects out")
    assert "about 3.8 times as many subjects would make it good" in confidence_sentence(utility)


def test_every_region_belongs_to_a_part():
    parts = {segment(stem) for stem in ALL}
    assert {segment("left wrist volar"), segment("left wrist dorsal")} == {"left wrist"}
    assert segment("right shin") == segment("right lower leg lateral") == "right lower leg"
    assert segment("left palm") == "left hand"
    assert segment("left lower back") == "left lower back"
    assert segment("left ear") == segment("nose") == "head"
    assert parts >= {"head", "neck", "hand", "foot", "thigh", "forearm", "sternum"}
    assert len(parts) < 40
    assert {great_part(f"left {stem}") for stem in ALL} == {"head", "neck", "torso", "left arm", "left leg"}
    assert great_part("sternum") == "torso"
