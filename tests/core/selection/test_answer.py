# SPDX-License-Identifier: GPL-3.0-or-later
"""The one answer: the best product, else a region; what others cost; how sure; comparisons."""

from functools import partial

import numpy as np
import pytest

from w2w.core.patches.body_parts import PRODUCTS, segment
from w2w.core.selection.answer import answer, compared
from w2w.core.selection.headline import short
from w2w.core.selection.scored import ScoredMap, compare, product_patches, product_places

from . import made_map

ranked = partial(made_map.ranked, half_width=0.05)

HIPS = ("hip", "left hip", "right hip", "left front hip", "right front hip")


def where(patches, *parts):
    return np.array([segment(region) in parts for region in patches.regions])


def test_the_best_product_is_named_and_what_a_product_of_each_other_part_costs(patches, bundled_body):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    expected[where(patches, "head")] = 0.885
    expected[where(patches, "left hand", "right hand", "left wrist", "right wrist")] = 0.8
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body))
    assert spoken.sentence() == (
        "A belt clip: F1 .90 on clips cut out (.85 to .95). "
        "An earbud does as well; a watch costs .10, an ankle band .30."
    )
    assert spoken.product == "belt clip"
    assert patches.regions[spoken.patch] in ("left hip", "right hip")


def test_between_doing_as_well_and_a_cost_that_is_shown_a_place_may_do_as_well(patches, bundled_body):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    head = where(patches, "head")
    expected[head] = 0.86
    drawn = np.tile(expected, (40, 1))
    drawn[::2, head] += 0.06  # on every other resample it does better than the belt clip
    spoken = answer(ScoredMap(ranked(expected, mean_samples=drawn), patches, bundled_body))
    assert "An earbud may cost .04; a watch costs .30" in spoken.sentence()
    earbud = next(score for score in spoken.products if score.name == "earbud")
    assert earbud.cost.verdict() == "may do as well"
    assert not earbud.cost.as_good


@pytest.mark.parametrize(
    ("costs", "as_good"), [(0.006, True), (0.0149, True), (0.0249, True), (0.0251, False)]
)
def test_at_most_two_hundredths_as_they_are_shown_do_as_well(patches, bundled_body, costs, as_good):
    expected = np.where(where(patches, *HIPS), 0.9, 0.9 - costs)
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body))
    watch = next(score for score in spoken.products if score.name == "watch")
    assert watch.cost.as_good is as_good
    assert (short(watch.cost.expected) <= ".02") is as_good
    assert ("does as well" in spoken.sentence() or "do as well" in spoken.sentence()) is as_good


@pytest.mark.parametrize("ahead", [-0.0024, 0.0024])
def test_of_products_that_a_seed_decides_between_the_commonest_is_recommended(patches, bundled_body, ahead):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    expected[where(patches, "head")] = 0.9 + ahead
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body))
    assert spoken.product == "belt clip"
    assert spoken.products[0] == spoken.base
    assert "An earbud does as well" in spoken.sentence()
    expected[where(patches, "head")] = 0.9026
    assert answer(ScoredMap(ranked(expected), patches, bundled_body)).product == "earbud"


def test_glasses_are_spoken_of_in_the_plural(patches, bundled_body):
    scored = ScoredMap(ranked(np.where(where(patches, "head"), 0.5, 0.9)), patches, bundled_body)
    assert compared([scored.named("glasses")]) == "Glasses cost .40."
    assert compared([scored.named("watch"), scored.named("shoe")]) == "A watch and a shoe do as well."
    assert compared([]) == ""


def test_without_a_product_among_the_best_a_region_is_named_and_what_a_product_costs(patches, bundled_body):
    group = np.array([region == "left thigh front" for region in patches.regions])
    luckiest = int(np.flatnonzero(group)[0])
    expected = np.where(group, 0.9, 0.6)
    expected[luckiest] = 0.91
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body))
    start = "Left thigh front (29 by 14 cm), no usual product there: F1 .90 on clips cut out (.85 to .95)."
    assert spoken.sentence().startswith(start)
    assert "a watch costs .30" in spoken.sentence().lower() or "a watch .30" in spoken.sentence()
    middle = bundled_body.vertices[patches.vertices[group]].mean(axis=0)
    away = np.linalg.norm(bundled_body.vertices[patches.vertices] - middle, axis=1)
    assert away[spoken.patch] < away[luckiest]
    assert not spoken.product
    assert {round(score.cost.expected, 3) for score in spoken.products} == {0.3}


def test_a_region_is_named_only_if_all_of_it_does_as_well(patches, bundled_body):
    group = np.flatnonzero([region == "left thigh front" for region in patches.regions])
    expected = np.full(len(patches), 0.6)
    expected[group[1:]] = 0.9
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body)).sentence()
    assert spoken.startswith("A spot of ")
    assert " on the left thigh front, no usual product there: F1 .90" in spoken


@pytest.mark.parametrize(
    ("chance", "words"),
    [
        (0.93, "A belt clip: F1 .90 on clips cut out (.85 to .95). A watch costs .30"),
        (
            0.84,
            "These clips hardly tell places apart; it beats an average place with 84 %. A watch costs .30",
        ),
        (
            0.64,
            "Anywhere on the body: F1 .61 on clips cut out (.56 to .66). "
            "These clips cannot show that one place is better.",
        ),
    ],
)
def test_clips_that_hardly_tell_places_apart_still_name_the_best_with_its_chance(
    patches, bundled_body, chance, words
):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    spoken = answer(ScoredMap(ranked(expected, beats_average=chance), patches, bundled_body))
    assert words in spoken.sentence()


def test_a_place_below_an_average_one_is_not_praised_under_wishes_either(patches, bundled_body):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    no_hips = ~where(patches, *HIPS)
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body, no_hips))
    assert spoken.lead() == "It is not expected to do as well as an average place on the whole body"
    nowhere = answer(ScoredMap(ranked(expected, beats_average=0.5), patches, bundled_body, no_hips))
    assert nowhere.sentence().startswith("Anywhere that is allowed: F1 .60")


def test_the_lead_is_over_an_average_place_and_over_what_people_wear(patches, bundled_body):
    hips, head = where(patches, *HIPS), where(patches, "head")
    expected = np.where(hips, 0.8, 0.6) + np.where(head, 0.25, 0)
    said = answer(ScoredMap(ranked(expected), patches, bundled_body)).lead()
    gain = short(0.85 - float(expected.mean()))
    assert (
        said == f"It beats an average place on other clips by about {gain} (93 % sure) and a belt clip by .05"
    )
    for lead, as_good in ((0.02, True), (0.03, False)):  # the same edge as in the sentence
        close = answer(ScoredMap(ranked(np.where(head, 0.8 + lead, expected)), patches, bundled_body)).lead()
        assert close.endswith("; a belt clip does as well") == as_good
    belt = answer(ScoredMap(ranked(np.where(hips, 0.8, 0.6)), patches, bundled_body)).lead()
    assert "belt clip" not in belt
    unknown = ranked(expected, errors=np.empty((0, 0)))
    assert answer(ScoredMap(unknown, patches, bundled_body)).lead() == ""


def test_too_few_clips_give_no_interval(patches, bundled_body):
    few = ranked(np.full(len(patches), 0.94), clips=3)
    sentence = answer(ScoredMap(few, patches, bundled_body)).sentence()
    assert "F1 .94 on clips cut out (from at most 3 clips per activity: too few for an interval)" in sentence


def test_one_activity_of_few_clips_leaves_no_interval_either(patches, bundled_body):
    clips = {"truth": np.repeat([0, 1], [9, 4]), "clip": np.array([f"clip {number}" for number in range(13)])}
    few = ranked(np.full(len(patches), 0.94), **clips)
    sentence = answer(ScoredMap(few, patches, bundled_body)).sentence()
    assert "F1 .94 on clips cut out (from only 4 clips of walk: too few for an interval)" in sentence


def test_a_loose_product_scores_the_mean_of_where_it_moves(patches, bundled_body):
    pocket = np.array([region == "left front pocket" for region in patches.regions])
    expected = np.full(len(patches), 0.5)
    expected[np.flatnonzero(pocket)[0]] = 0.9
    score = compare(ScoredMap(ranked(expected), patches, bundled_body), ["left trouser pocket"])[0]
    assert score.expected == pytest.approx(expected[pocket].mean())
    assert score.under == tuple(np.flatnonzero(pocket))


def test_wishes_leave_out_products(patches, bundled_body):
    no_arms = ~np.array(["wrist" in region or "hand" in region for region in patches.regions])
    expected = np.linspace(0.5, 0.9, len(patches))
    spoken = answer(ScoredMap(ranked(expected), patches, bundled_body, no_arms))
    assert "watch" not in [score.name for score in spoken.products]
    assert {"belt clip", "shoe"} <= {score.name for score in spoken.products}


def test_products_and_places_compare_by_any_of_their_names(patches, bundled_body):
    expected = np.linspace(0.5, 0.9, len(patches))
    scored = ScoredMap(ranked(expected), patches, bundled_body)
    words = ["smartwatch", "pendant", "left thigh front", "right shoe"]
    scores = compare(scored, words)
    assert sorted(score.name for score in scores) == ["left thigh front", "necklace", "shoe", "watch"]
    assert [score.expected for score in scores] == sorted((score.expected for score in scores), reverse=True)
    assert next(score.side for score in scores if score.name == "shoe") == "right"
    with pytest.raises(ValueError, match='called "rign"'):
        compare(scored, ["rign"])


def test_every_product_has_a_patch_within_reach_on_the_body(patches, bundled_body):
    for product in PRODUCTS.values():
        for side in product.sides:
            assert (product.name, side) in product_places(patches, bundled_body)
    assert set(product_patches(patches, bundled_body).values()) >= {"left watch", "right shoe", "chest strap"}
