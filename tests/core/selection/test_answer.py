# SPDX-License-Identifier: GPL-3.0-or-later
"""The one answer: the best product, else a region; what others cost; how sure; comparisons."""

from functools import partial

import numpy as np
import pytest

from w2w.core.patches.body_parts import PRODUCTS, segment
from w2w.core.ranking.folds import SUBJECT_OUT
from w2w.core.selection.answer import comparison, find_answer
from w2w.core.selection.headline import short
from w2w.core.selection.scored import ScoredMap, compare, product_patches, product_places

from . import made_map

ranked = partial(made_map.ranked, half_width=0.05)


def scored(utility, patches, body, limits=None, **more):
    """The map by its clips alone."""
    return ScoredMap(utility, patches, body, limits, **more)


HIPS = ("hip", "left hip", "right hip", "left front hip", "right front hip")


def where(patches, *parts):
    return np.array([segment(region) in parts for region in patches.regions])


def ring_fingers(patches, body):
    """The patches at which a ring sits."""
    at = [patch for (name, _), patch in product_places(patches, body).items() if name == "ring"]
    return np.isin(np.arange(len(patches)), at)


def test_the_best_product_is_named_and_what_a_product_of_each_other_part_costs(patches, bundled_body):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    expected[where(patches, "head")] = 0.885
    expected[where(patches, "left hand", "right hand", "left wrist", "right wrist")] = 0.8
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    assert spoken.sentence() == (
        "Keep the belt clip: nothing tried is shown to do better here. "
        "It will tell about 9 of 10 moments right, between 9 and 10; an earbud is as good."
    )
    assert spoken.detail() == ("F1 .90 (.85 to .95). A watch costs .10, an ankle band .30.")
    assert spoken.product == "belt clip"
    assert patches.regions[spoken.patch] in ("left hip", "right hip")


def test_a_cost_whose_interval_holds_zero_is_one_that_may_be(patches, bundled_body):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    expected[where(patches, "head")] = 0.86
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    assert "An earbud may cost .04; a watch costs .30" in spoken.detail()
    earbud = next(score for score in spoken.products if score.name == "earbud")
    assert earbud.cost.low < 0 < earbud.cost.high
    assert earbud.cost.verdict() == "may cost"
    assert not earbud.cost.as_good


@pytest.mark.parametrize(
    ("costs", "as_good"), [(0.006, True), (0.0149, True), (0.0249, True), (0.0251, False)]
)
def test_at_most_two_hundredths_as_they_are_shown_do_as_well(patches, bundled_body, costs, as_good):
    expected = np.where(where(patches, *HIPS), 0.9, 0.9 - costs)
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    watch = next(score for score in spoken.products if score.name == "watch")
    assert watch.cost.as_good is as_good
    assert (short(watch.cost.expected) <= ".02") is as_good
    assert ("is as good" in spoken.sentence() or "are as good" in spoken.sentence()) is as_good


@pytest.mark.parametrize("ahead", [-0.0024, 0.0024])
def test_of_products_that_a_seed_decides_between_the_commonest_is_recommended(patches, bundled_body, ahead):
    expected = np.where(where(patches, *HIPS), 0.9, 0.6)
    expected[where(patches, "head")] = 0.9 + ahead
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    assert spoken.product == "belt clip"
    assert spoken.products[0] == spoken.base
    assert "an earbud is as good" in spoken.sentence()


def test_without_a_habit_that_may_be_worn_the_best_is_recommended(patches, bundled_body):
    hips = where(patches, *HIPS)
    expected = np.where(where(patches, "head"), 0.9, 0.6)
    spoken = find_answer(scored(ranked(expected), patches, bundled_body, ~hips))
    assert spoken.habit is None
    assert spoken.gain is None
    assert spoken.sentence() == "Wear an earbud. It will tell about 9 of 10 moments right, between 9 and 10."


def test_glasses_are_one_thing_to_wear(patches, bundled_body):
    found = scored(ranked(np.where(where(patches, "head"), 0.5, 0.9)), patches, bundled_body)
    assert comparison([found.named("glasses")]) == "A pair of glasses costs .40."
    assert comparison([found.named("watch"), found.named("shoe")]) == "A watch and a shoe are as good."
    assert comparison([]) == ""


def test_without_a_product_among_the_best_a_region_is_named_and_what_a_product_costs(patches, bundled_body):
    group = np.array([region == "left thigh front" for region in patches.regions])
    luckiest = int(np.flatnonzero(group)[0])
    expected = np.where(group, 0.9, 0.6)
    expected[luckiest] = 0.91
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    assert spoken.sentence() == (
        "Wear a sensor on the left thigh front (29 by 14 cm), where no usual product sits: "
        "it tells about 9 of 10 moments right, where a belt clip tells 6."
    )
    assert "a watch costs .30" in spoken.detail().lower()
    middle = bundled_body.vertices[patches.vertices[group]].mean(axis=0)
    away = np.linalg.norm(bundled_body.vertices[patches.vertices] - middle, axis=1)
    assert away[spoken.patch] < away[luckiest]
    assert not spoken.product
    assert {round(score.cost.expected, 3) for score in spoken.products} == {0.3}


def test_a_region_is_named_only_if_all_of_it_is_as_good(patches, bundled_body):
    group = np.flatnonzero([region == "left thigh front" for region in patches.regions])
    expected = np.full(len(patches), 0.6)
    expected[group[1:]] = 0.9
    spoken = find_answer(scored(ranked(expected), patches, bundled_body)).sentence()
    assert spoken.startswith("Wear a sensor on a spot of ")
    assert " on the left thigh front, where no usual product sits: it tells about 9 of 10" in spoken


def test_a_gain_that_is_shown_is_said_in_moments(patches, bundled_body):
    expected = np.where(ring_fingers(patches, bundled_body), 0.9, 0.3)
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    said = "Wear a ring: it tells about 9 of 10 moments right, where a belt clip tells 3."
    assert spoken.sentence() == said
    assert spoken.gain_shown
    assert spoken.detail().startswith("F1 .90 (.85 to .95). A belt clip: .30; count on half of that lead.")


def test_a_gain_that_is_not_shown_is_no_figure(patches, bundled_body):
    expected = np.where(where(patches, "head"), 0.64, 0.6)
    spoken = find_answer(scored(ranked(expected), patches, bundled_body))
    assert spoken.gain.expected < 0.04
    assert spoken.gain.low < 0
    assert spoken.sentence().startswith(
        "An earbud may do better than a belt clip; these clips cannot show by how much. It will tell"
    )
    assert "count on" not in spoken.detail()
    assert " A belt clip may cost .04" in spoken.detail()


@pytest.mark.parametrize(
    ("ahead", "product"), [(0.003, "belt clip"), (0.034, "belt clip"), (0.036, "earbud")]
)
def test_the_habit_is_kept_unless_a_gain_can_be_counted_on(patches, bundled_body, ahead, product):
    expected = np.where(where(patches, "head"), 0.6 + ahead, 0.6)
    assert find_answer(scored(ranked(expected), patches, bundled_body)).product == product
    watch = find_answer(scored(ranked(expected), patches, bundled_body, habit="smartwatch"))
    assert watch.habit.name == "watch"
    assert watch.keeps == (product == "belt clip")


def test_between_people_less_can_be_counted_on(patches, bundled_body):
    expected = np.where(where(patches, "head"), 0.64, 0.6)
    people = ranked(expected, protocol=SUBJECT_OUT)
    assert people.by_subject
    clips, others = (
        find_answer(scored(utility, patches, bundled_body)).gain for utility in (ranked(expected), people)
    )
    assert 0 < others.expected < clips.expected < 0.04


def test_places_that_are_shown_to_do_alike_are_not_chosen_among(patches, bundled_body):
    sure = {"errors": np.full((8, len(patches)), 1e-4)}
    spoken = find_answer(scored(ranked(np.full(len(patches), 0.94), **sure), patches, bundled_body))
    assert not spoken.differs
    assert not spoken.product
    tells = "It will tell about 9 of 10 moments right, between 9 and 10."
    assert spoken.sentence() == f"Wear it anywhere on the body: all places do alike. {tells}"
    few = where(patches, "head")
    allowed = find_answer(scored(ranked(np.full(len(patches), 0.94), **sure), patches, bundled_body, few))
    assert allowed.sentence().startswith("Wear it anywhere that is allowed: ")


def test_a_small_library_names_a_start_and_what_would_tell_most(patches, bundled_body):
    hand = ring_fingers(patches, bundled_body)
    unknown = {
        "errors": np.empty((0, 0)),
        "truth": np.repeat([0, 1], [3, 2]),
        "clip": np.arange(5).astype(str),
    }
    spoken = find_answer(scored(ranked(np.where(hand, 0.8, 0.7), **unknown), patches, bundled_body))
    assert spoken.sentence() == (
        "Start with a ring: it may do better than a belt clip. "
        "It will tell about 8 of 10 moments right. Three more clips of walk would tell most."
    )
    assert "F1 .80 (from at most 3 clips per activity: too few for an interval)" in spoken.detail()
    alike = find_answer(scored(ranked(np.full(len(patches), 0.7), **unknown), patches, bundled_body))
    assert alike.sentence().startswith("Start with a belt clip: nothing tried is shown to do better here. ")


def test_one_activity_of_few_clips_leaves_no_interval_either(patches, bundled_body):
    clips = {"truth": np.repeat([0, 1], [9, 4]), "clip": np.array([f"clip {number}" for number in range(13)])}
    few = ranked(np.full(len(patches), 0.94), **clips)
    said = find_answer(scored(few, patches, bundled_body)).detail()
    assert "F1 .94 (from only 4 clips of walk: too few for an interval)" in said


def test_a_loose_product_scores_the_mean_of_where_it_moves(patches, bundled_body):
    pocket = np.array([region == "left front pocket" for region in patches.regions])
    expected = np.full(len(patches), 0.5)
    expected[np.flatnonzero(pocket)[0]] = 0.9
    score = compare(scored(ranked(expected), patches, bundled_body), ["left trouser pocket"])[0]
    assert score.expected == pytest.approx(expected[pocket].mean())
    assert score.under == tuple(np.flatnonzero(pocket))


def test_wishes_leave_out_products(patches, bundled_body):
    no_arms = ~np.array(["wrist" in region or "hand" in region for region in patches.regions])
    expected = np.linspace(0.5, 0.9, len(patches))
    spoken = find_answer(scored(ranked(expected), patches, bundled_body, no_arms))
    assert "watch" not in [score.name for score in spoken.products]
    assert {"belt clip", "shoe"} <= {score.name for score in spoken.products}


def test_products_and_places_compare_by_any_of_their_names(patches, bundled_body):
    expected = np.linspace(0.5, 0.9, len(patches))
    found = scored(ranked(expected), patches, bundled_body)
    words = ["smartwatch", "pendant", "left thigh front", "right shoe"]
    scores = compare(found, words)
    assert sorted(score.name for score in scores) == ["left thigh front", "necklace", "shoe", "watch"]
    assert [score.expected for score in scores] == sorted((score.expected for score in scores), reverse=True)
    assert next(score.side for score in scores if score.name == "shoe") == "right"
    with pytest.raises(ValueError, match='called "rign"'):
        compare(found, ["rign"])


def test_every_product_has_a_patch_within_reach_on_the_body(patches, bundled_body):
    for product in PRODUCTS.values():
        for side in product.sides:
            assert (product.name, side) in product_places(patches, bundled_body)
    assert set(product_patches(patches, bundled_body).values()) >= {"left watch", "right shoe", "chest strap"}


def test_what_posture_alone_tells_is_said_next_to_what_all_tells(patches, bundled_body):
    flat = np.full(len(patches), 0.6)
    known = ranked(flat, posture=np.full((len(patches), 2), 0.35))
    assert (
        find_answer(scored(known, patches, bundled_body))
        .measured()
        .endswith("posture alone (the direction of gravity) gives .35")
    )
    assert "posture" not in find_answer(scored(ranked(flat), patches, bundled_body)).measured()
