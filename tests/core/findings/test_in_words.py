# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of a ranking in words: what is not known is not said, what is alike is said to be."""

from dataclasses import replace

import numpy as np

from tests.core.selection.made_map import ranked
from w2w.core.findings.in_words import (
    as_sentence,
    baked_sentence,
    may_move,
    patch_lines,
    pilot_sentences,
    placement_row,
    placement_sentence,
    product_row,
    sensor_sentences,
    sure_sentences,
)
from w2w.core.selection.headline import repeat_sentence

UTILITY = ranked([0.9, 0.8, 0.5])
FEW = ranked([0.9, 0.8, 0.5], clips=2)
PRODUCT = {"side": "left", "name": "watch", "expected_f1": 0.8, "costs": 0.1, "verdict": ""}
OWN = {
    "region": "left wrist", "expected_f1": 0.8, "expected_f1_interval": [0.7, 0.9], "costs": 0.1, "rank": 2,
    "of": 3, "verdict": "",
}  # fmt: skip


def test_a_sentence_begins_with_a_capital_and_has_one_full_stop():
    assert [as_sentence(text) for text in ("wear it", "Wear it.")] == ["Wear it."] * 2


def test_how_sure_an_answer_is_takes_what_it_says_and_what_the_map_says():
    found = sure_sentences({"detail": "As good elsewhere.", "measured": ""}, UTILITY)
    assert found == ["As good elsewhere.", f"{repeat_sentence(UTILITY)}."]


def test_a_product_says_what_it_costs_unless_it_is_as_good():
    assert product_row(PRODUCT) == ("Left watch", ".80, costs .10")
    assert product_row(PRODUCT | {"verdict": "may cost"})[1] == ".80, may cost .10"
    assert product_row(PRODUCT | {"verdict": "as good", "side": ""}) == ("Watch", ".80")


def test_a_placement_has_scores_once_it_is_ranked():
    assert [placement_row(None, patch) for patch in (-1, 4)] == ["new", "not ranked"]
    assert placement_row(OWN, 4) == "0.80   2 of 3"
    rank = "rank 2 of 3 among the sampled spots"
    told = f"Left wrist: expected F1 0.800 (0.70 to 0.90), {rank}, costs .10."
    assert placement_sentence(OWN, UTILITY) == told
    assert "too few for an interval), rank" in placement_sentence(OWN | {"verdict": "as good"}, FEW)


def lines(patch, utility=UTILITY, is_ranked=True):
    whole = replace(utility, mean_low=np.full(3, 0.3), mean_high=np.full(3, 0.6))
    return patch_lines(patch, whole, utility.expected_mean, np.full(3, 0.45), [0], is_ranked)


def test_a_patch_has_its_interval_where_there_are_clips_for_one():
    assert lines(0) == (
        "expected F1 0.90 (0.84 to 0.96), as good",
        "rank 1 of 3; on these clips 0.45 (0.30 to 0.60)",
    )
    assert lines(2)[0] == "expected F1 0.50 (0.44 to 0.56)"
    assert lines(0, FEW) == (
        "expected F1 0.90 (too few clips for an interval)",
        "rank 1 of 3, as good; on these clips 0.45",
    )
    assert lines(1, is_ranked=False)[0] == "expected F1 0.80 over the activities that count"


def test_a_sensor_of_a_set_says_what_is_known_of_it():
    card = {"slip_cm": 3.2, "turn_deg": 20, "in_words": "Above the wrist.", "needs": {"sentence": "25 Hz do"}}
    assert (may_move(card), may_move({"slip_cm": 3.2}), may_move({})) == ("3 cm, 20°", "3 cm", "")
    f1 = (0.8, 0.7, 0.9)
    assert list(sensor_sentences("Left wrist", f1, card, ["left elbow", "left hand"], UTILITY)) == [
        "Left wrist. F1 with the sensors so far: .80 (.70 to .90). Above the wrist.",
        "25 Hz do.",
        "Or instead: left elbow or left hand.",
    ]
    (alone,) = sensor_sentences("Left wrist", f1, {}, [], FEW)
    assert "too few for an interval" in alone


def test_a_pilot_says_all_that_it_found_in_order():
    pilot = {"sentence": "With your pilot: F1 .8.", "next": "two more", "cautions": [{"text": "few people"}]}
    assert pilot_sentences(pilot) == ["With your pilot: F1 .8.", "Few people.", "Two more."]
    left = pilot_sentences(pilot | {"skipped": [["a.csv", "it is empty"]]})[-1]
    assert left == "Left out: a.csv: it is empty."


def test_a_bake_says_how_and_what_it_could_not():
    paths = {"one": "fast path", "two": "general path: a modifier"}
    assert baked_sentence(paths, 8, []) == "Baked 2 clips on 8 spots, 1 by Blender's evaluated mesh"
    failed = baked_sentence(paths | {"three": ""}, 8, ["three (it is empty)"])
    assert failed.startswith("Baked 2 clips on 8 spots")
    assert failed.endswith("Not baked: three (it is empty)")
    worn = "general path: 3 sensors are on Shirt; cloth caught on the body: Shirt in 4 of 90 frames"
    assert ". Cloth caught on the body in one: do not trust its" in baked_sentence({"one": worn}, 8, [])
