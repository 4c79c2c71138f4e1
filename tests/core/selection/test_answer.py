# SPDX-License-Identifier: GPL-3.0-or-later
"""The one answer: products among the places that tie, else the region; ties; comparisons."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from w2w.core.patches.body_parts import PRODUCTS, segment
from w2w.core.selection.answer import ScoredMap, answer, compare, product_patches, product_places
from w2w.core.selection.headline import short

from . import made_map

ranked = partial(made_map.ranked, half_width=0.05)


def where(patches, *parts):
    return np.array([segment(region) in parts for region in patches.regions])


def test_two_products_of_different_parts_are_named_with_the_lower_f1(patches, bundled_body):
    group = where(patches, "hip", "left hip", "right hip", "sternum", "left front hip", "right front hip")
    expected = np.where(group, 0.9, 0.6) + np.where(where(patches, "sternum"), 0.02, 0)
    said = answer(ScoredMap(ranked(expected, group), patches, bundled_body))
    assert said.sentence() == "A chest strap or a belt clip: F1 .90 (.85 to .95). A watch costs .30."
    assert [score.name for score in said.named] == ["chest strap", "belt clip"]
    assert said.patch == said.named[0].patch
    assert patches.regions[said.patch] == "sternum"


@pytest.mark.parametrize("costs", [0.004, 0.006, 0.3])
def test_what_another_product_costs_is_said_where_two_digits_show_it(patches, bundled_body, costs):
    group = where(patches, "hip", "left hip", "right hip", "left front hip", "right front hip")
    said = answer(ScoredMap(ranked(np.where(group, 0.9, 0.9 - costs), group), patches, bundled_body))
    assert said.sentence().endswith(f"costs {short(costs)}.") is (short(costs) != ".00")


def test_without_a_product_among_the_best_a_region_its_size_and_its_middle_are_named(patches, bundled_body):
    group = np.array([region == "left thigh front" for region in patches.regions])
    luckiest = int(np.flatnonzero(group)[0])
    expected = np.where(group, 0.9, 0.6)
    expected[luckiest] = 0.91
    said = answer(ScoredMap(ranked(expected, group), patches, bundled_body))
    assert said.sentence() == ("Left thigh front (29 by 14 cm): F1 .90 (.85 to .95). A watch costs .30.")
    middle = bundled_body.vertices[patches.vertices[group]].mean(axis=0)
    away = np.linalg.norm(bundled_body.vertices[patches.vertices] - middle, axis=1)
    assert away[said.patch] < away[luckiest]
    assert not said.named


def test_where_all_tie_no_place_is_praised(patches, bundled_body):
    everywhere = np.ones(len(patches), bool)
    expected = np.full(len(patches), 0.94)
    cannot = "F1 .94 (.89 to .99). These clips cannot show that one place is better."
    said = answer(ScoredMap(ranked(expected, everywhere), patches, bundled_body))
    assert said.sentence() == f"Anywhere on the body: {cannot}"
    weak = replace(ranked(expected, expected > 1), can_rank=False)
    assert answer(ScoredMap(weak, patches, bundled_body)).sentence() == f"Anywhere on the body: {cannot}"
    left = where(patches, "left thigh")
    said = answer(ScoredMap(ranked(expected, everywhere), patches, bundled_body, left))
    assert said.sentence() == f"Anywhere that is allowed: {cannot}"


def test_too_few_clips_give_no_interval(patches, bundled_body):
    few = ranked(np.full(len(patches), 0.94), np.ones(len(patches), bool), clips=3)
    sentence = answer(ScoredMap(few, patches, bundled_body)).sentence()
    assert "F1 .94 (from at most 3 clips per activity: too few for an interval)" in sentence


def test_one_activity_of_few_clips_leaves_no_interval_either(patches, bundled_body):
    clips = {"truth": np.repeat([0, 1], [9, 4]), "clip": np.array([f"clip {number}" for number in range(13)])}
    few = ranked(np.full(len(patches), 0.94), np.ones(len(patches), bool), **clips)
    sentence = answer(ScoredMap(few, patches, bundled_body)).sentence()
    assert "F1 .94 (from only 4 clips of walk: too few for an interval)" in sentence


def test_a_loose_product_scores_the_mean_of_where_it_moves(patches, bundled_body):
    pocket = np.array([region == "left front pocket" for region in patches.regions])
    expected = np.full(len(patches), 0.5)
    expected[np.flatnonzero(pocket)[0]] = 0.9
    found = compare(ScoredMap(ranked(expected, pocket), patches, bundled_body), ["left trouser pocket"])[0]
    assert found.expected == pytest.approx(expected[pocket].mean())


def test_a_loose_product_is_as_good_only_if_it_is_wherever_it_moves(patches, bundled_body):
    pocket = np.array([region == "left front pocket" for region in patches.regions])
    most = pocket.copy()
    most[np.flatnonzero(pocket)[-1]] = False
    for group, named in ((pocket, ["trouser pocket"]), (most, [])):
        said = answer(ScoredMap(ranked(np.where(group, 0.9, 0.6), group), patches, bundled_body))
        assert [score.name for score in said.named] == named
    assert said.where.startswith("left front pocket (")


def test_what_ties_is_said_once_both_sides_together(patches, bundled_body):
    thighs = where(patches, "left thigh", "right thigh", "sternum")
    said = answer(ScoredMap(ranked(np.where(thighs, 0.9, 0.6), thighs), patches, bundled_body))
    assert said.ties == "Anywhere on thighs or sternum does as well."


def test_wishes_leave_out_products(patches, bundled_body):
    no_arms = ~np.array(["wrist" in region or "hand" in region for region in patches.regions])
    expected = np.linspace(0.5, 0.9, len(patches))
    said = answer(ScoredMap(ranked(expected, expected > 0.8), patches, bundled_body, no_arms))
    assert "watch" not in [score.name for score in said.products]
    assert {"belt clip", "shoe"} <= {score.name for score in said.products}


def test_products_and_places_compare_by_any_of_their_names(patches, bundled_body):
    expected = np.linspace(0.5, 0.9, len(patches))
    scored = ScoredMap(ranked(expected, expected > 0.8), patches, bundled_body)
    words = ["smartwatch", "pendant", "left thigh front", "right shoe"]
    found = compare(scored, words)
    assert sorted(score.name for score in found) == ["left thigh front", "necklace", "shoe", "watch"]
    assert [score.expected for score in found] == sorted((score.expected for score in found), reverse=True)
    assert next(score.side for score in found if score.name == "shoe") == "right"
    with pytest.raises(ValueError, match='called "rign"'):
        compare(scored, ["rign"])


def test_every_product_has_a_patch_within_reach_on_the_body(patches, bundled_body):
    for product in PRODUCTS.values():
        for side in product.sides:
            assert (product.name, side) in product_places(patches, bundled_body)
    assert set(product_patches(patches, bundled_body).values()) >= {"left watch", "right shoe", "chest strap"}
