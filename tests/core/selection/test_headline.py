# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a ranking: a patch where one stands out, parts of the body where many are as good."""

from pathlib import Path

import numpy as np
import pytest

from w2w.core.patches.body_parts import ALL, great_part, segment
from w2w.core.selection.headline import WORN, doubt, doubted, more_clips, repeat_sentence, short

from .made_map import ranked

DOCS = Path(__file__).parents[3] / "docs"


@pytest.mark.parametrize(
    ("reliability", "clips", "sentence", "more"),
    [
        (0.75, 36, "Map reliability .75 (aim for .85); it takes about 32 more clips for each activity", 32),
        (0.85 * 9 / (0.85 * 9 + 0.15 * 10), 9, "it takes about 1 more clip for each activity", 1),
        (0.9, 12, "Map reliability .90 (aim for .85). On people's", 0),
        (0.3, 12, "it takes more than 10 times as many clips", None),
        (-0.1, 12, "Map reliability -.10 (aim for .85); it takes more than 10 times", None),
    ],
)  # fmt: skip
def test_how_many_more_clips_would_do(reliability, clips, sentence, more):
    utility = ranked([0.5], reliability, clips)
    assert sentence in repeat_sentence(utility)
    assert more_clips(utility) == more


def test_how_worn_sensors_compared_is_said_with_which_was_higher():
    said = repeat_sentence(ranked([0.5, 0.7], 0.9))
    assert said.endswith(f"F1 was {WORN} than expected of other people (docs/truth.md)")


def test_how_worn_sensors_compared_is_what_the_comparison_of_today_measured():
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in (DOCS / "evidence" / "people.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("|")
    ]
    column = next(row for row in rows if row[-1] == "level").index("level")
    tests = [row for row in rows if row[1].startswith("all ") and len(row) > column]
    above = [float(row[column].split(" (")[0]) for row in tests]
    assert len(above) == 4
    lower, higher = (f"{end:.2f}".lstrip("0") for end in (max(above), -min(above)))
    assert f"{lower} lower to {higher} higher" == WORN
    level = f"Simulated F1 lay from {higher} below to {lower} above people's"
    assert level in (DOCS / "truth.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("chance", "words"),
    [
        (0.9, ""),
        (0.89, "These clips hardly tell"),
        (0.65, "These clips hardly"),
        (0.64, "These clips do not"),
    ],
)
def test_a_picture_says_how_little_the_clips_tell_places_apart(chance, words):
    utility = ranked([0.5, 0.7], beats_average=chance)
    assert doubt(utility).startswith(words)
    assert doubted(utility, "Best").split(". ")[-1] == "Best"
    assert bool(doubt(utility)) is (chance < 0.9)


def test_clips_that_cannot_be_halved_are_said_not_to_tell():
    utility = ranked([0.5], np.nan, 2, errors=np.empty((0, 0)))
    assert repeat_sentence(utility).startswith("How sure this is cannot be told")


def test_of_subjects_it_says_how_many_times_as_many():
    utility = ranked([0.5], 0.6, protocol="leave one of 5 subjects out")
    assert "it takes about 3.8 times as many subjects" in repeat_sentence(utility)


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


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.614, ".61"), (-0.031, "-.03"), (-0.004, ".00"), (0.996, "1.00"), (-0.999, "-1.00"), (10.05, "10.05")],
)
def test_two_decimals_without_a_zero_before_them_and_none_below_zero(value, text):
    assert short(value) == text
