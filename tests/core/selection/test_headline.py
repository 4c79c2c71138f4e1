# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a ranking: a patch where one stands out, parts of the body where many are as good."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.patches.body_parts import ALL, great_part, segment
from w2w.core.selection.headline import (
    BELOW_AVERAGE,
    CANNOT_RANK,
    WORN,
    as_good_as,
    confidence_sentence,
    more_clips,
    spot_caution,
)

from .made_map import ranked


def scored(group, best):
    expected = np.where(group, 0.75, 0.5)
    expected[best] = 0.84
    return expected


def test_constraints_that_leave_out_the_best_leave_out_its_equals():
    """The best that is allowed is one of the group, or can be told from it: then it stands alone."""
    hand, thigh = np.arange(9) < 3, np.arange(9) > 5
    best, top = 7, 1
    expected = scored(hand, top)
    expected[best] = 0.7
    apart = ranked(expected, hand)
    assert as_good_as(best, apart, ~hand).tolist() == [best]
    among = ranked(expected, hand | thigh)
    assert as_good_as(best, among, ~hand).tolist() == np.flatnonzero(thigh).tolist()
    assert as_good_as(top, among).tolist() == np.flatnonzero(hand | thigh).tolist()


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
