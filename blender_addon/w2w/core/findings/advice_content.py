# SPDX-License-Identifier: GPL-3.0-or-later
"""A choice of sensors as plain values in files."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..files import DIGITS
from ..patches.patches import PatchSet
from ..ranking.costs import Cost
from ..ranking.utility import UtilityMap
from ..selection.advice import Advice
from ..selection.answer import Answer
from ..selection.headline import mean_sentence, more_clips, repeat_sentence
from ..selection.joint import WornSet
from ..selection.promise import Promise
from ..selection.scored import PlaceScore
from ..study.needs import Loss, Need
from ..study.variants import ALONE, KNOBS
from .cautions import Caution, head


def advice_content(
    advice: Advice, utility: UtilityMap, patches: PatchSet, cautions: Sequence[Caution]
) -> dict[str, Any]:
    """The choice as plain values, under what speaks against it."""
    return {
        "answer": answer_content(advice.answer, patches, cautions),
        "cards": [
            {"sensor": called(card.patch, advice, patches), **asdict(card), "in_words": card.in_words()}
            for card in advice.cards
        ],
        "best_single_patch": {
            **patch_content(advice.best, utility, patches),
            "clips_rank_placements": utility.can_rank,
        },
        "mean": {
            "weights": dict(zip(utility.activities, utility.weights.tolist(), strict=True)),
            "sentence": mean_sentence(utility),
        },
        "map_reliability": None if np.isnan(utility.reliability) else rounded(utility.reliability),
        "more_clips_per_activity": more_clips(utility),
        "map_sentence": repeat_sentence(utility),
        "worn_together": None if advice.worn is None else worn_content(advice.worn, advice, utility, patches),
    }


def answer_content(answer: Answer, patches: PatchSet, cautions: Sequence[Caution]) -> dict[str, Any]:
    """Where to wear one sensor, in a sentence and by products, or what stops the answer."""
    sentence = head(answer.sentence(), cautions)
    return {
        "sentence": sentence,
        "detail": answer.detail(),
        **habit_content(answer),
        "patch": answer.patch,
        "name": patches.names[answer.patch],
        **interval_content("expected_f1", *answer.f1),
        **({} if np.isnan(answer.posture) else {"f1_by_posture": rounded(answer.posture)}),
        "measured": answer.measured(),
        "recommended": answer.product if sentence == answer.sentence() else "",
        "costs_are_against": list(answer.base.under),
        "compared_with": [score.name for score in answer.others],
        "products": [place_content(score, patches) for score in answer.products],
    }


def habit_content(answer: Answer) -> dict[str, Any]:
    """What people wear anyway, and what to count on over it, if it is shown to gain; nothing without one."""
    if answer.habit is None or answer.gain is None:
        return {}
    return {
        "habit": answer.habit.name,
        **({"gain": rounded(answer.gain.expected / 2)} if answer.gain_shown else {}),
    }


def need_content(need: Need) -> dict[str, Any]:
    """How cheap a sensor may be: the sentence, a row for each thing that can be cheaper, all values tried."""
    values = [_loss_content(loss) for loss in need.losses]
    rows = []
    for knob in need.own:
        tried, found = need.of(knob), need.cheapest(knob)
        if knob == ALONE:
            rows += [{"parameter": loss.name, "as_run": "", "next": _loss_content(loss)} for loss in tried]
        elif tried:
            after = tried[tried.index(found) + 1 :] if found else tried
            rows.append(
                {"parameter": knob, "as_run": KNOBS[knob].text(need.own[knob])}
                | ({"cheapest": _loss_content(found) | {"value": found.bound}} if found else {})
                | ({"next": _loss_content(after[0])} if after else {})
            )
    together = {"together": _loss_content(need.together)} if need.together else {}
    parts = [_loss_content(part) | {"rate_hz": part.value} for part in need.parts]
    content = {"place": need.place, "patch": need.patch, "sentence": need.sentence(), "f1": rounded(need.f1)}
    return content | {"rows": rows, "values": values, **together, "parts": parts}


def with_needs(cards: Sequence[dict[str, Any]], found: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The cards, each with what is needed at its patch (`need_content`), if that was found."""
    of_patch = {need["patch"]: need for need in found}
    return [
        card | ({"needs": of_patch[card["patch"]]} if card["patch"] in of_patch else {}) for card in cards
    ]


def needs_on(cards: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """What is needed by those cards that say it."""
    said = [(card.get("needs"), card["patch"]) for card in cards]
    return [need for need, patch in said if isinstance(need, dict) and need.get("patch") == patch]


def _loss_content(loss: Loss) -> dict[str, Any]:
    return {"parameter": loss.knob, "value": loss.name, "f1": rounded(loss.f1)} | cost_content(loss.cost)


def place_content(score: PlaceScore, patches: PatchSet) -> dict[str, Any]:
    """One sensor on a product or at a named place."""
    return {
        "name": score.name,
        "side": score.side,
        "patch": score.patch,
        "patch_name": patches.names[score.patch],
        **interval_content("expected_f1", *score.f1),
        "expected_f1_of": {name: rounded(f1) for name, f1 in score.by_activity.items()},
        **cost_content(score.cost),
    }


def cost_content(cost: Cost) -> dict[str, Any]:
    """What a place costs against the recommended one, and whether it is as good."""
    return {
        "costs": round(cost.expected, 2),
        "costs_interval": [round(cost.low, 2), round(cost.high, 2)],
        "as_good": cost.as_good,
        "verdict": cost.verdict(),
    }


def worn_content(worn: WornSet, advice: Advice, utility: UtilityMap, patches: PatchSet) -> dict[str, Any]:
    """Patches chosen to be worn together, with the expected F1 of the first, the first two, and so on."""
    promise = worn.promise
    return {
        "sentence": worn.sentence(),
        "target": worn.target,
        "every_activity": worn.every_activity,
        "reached": worn.reached,
        "cost": worn.price,
        **expected_content(promise, len(worn.order)),
        "f1": dict(zip(worn.activities, map(rounded, promise.f1[-1]), strict=True)),
        "places": [
            {
                **patch_content(patch, utility, patches),
                "product": advice.products.get(patch, ""),
                **expected_content(promise, number, "_so_far"),
                "mean_f1_so_far": rounded(worn.raw_mean[number - 1]),
            }
            for number, patch in enumerate(worn.order, start=1)
        ],
        "alternatives": [[called(patch, advice, patches) for patch in some] for some in advice.alternatives],
        "next_sensor": next_worn(worn, advice, patches),
    }


def called(patch: int, advice: Advice, patches: PatchSet) -> str:
    """The product that is worn at a patch, else the patch's own name."""
    return advice.products.get(int(patch), patches.names[patch])


def next_worn(worn: WornSet, advice: Advice, patches: PatchSet) -> dict[str, Any] | None:
    """The best sensor to add to a set; None if no more sensors are allowed."""
    promise = worn.with_next
    if promise is None:
        return None
    name = called(worn.further[0], advice, patches)
    reaches = f"the set reaches {promise.text(worn.caution)}"
    return {
        "patch": worn.further[0],
        "name": name,
        **expected_content(promise, len(promise.mean)),
        "sentence": f"the best sensor to add is {name}; with it, {reaches}",
    }


def expected_content(promise: Promise, sensors: int, suffix: str = "") -> dict[str, Any]:
    """Expected F1 of the first `sensors` of a set."""
    at = (values[sensors - 1] for values in (promise.mean, promise.low, promise.high))
    return interval_content(f"expected_f1{suffix}", *at)


def interval_content(name: str, value: float, low: float, high: float) -> dict[str, Any]:
    """A score and its interval under a name."""
    return {name: rounded(value), f"{name}_interval": [rounded(low), rounded(high)]}


def patch_content(patch: int, utility: UtilityMap, patches: PatchSet) -> dict[str, Any]:
    """Number, name, region, vertex and scores of a patch."""
    return {
        "patch": int(patch),
        "name": patches.names[patch],
        "region": patches.regions[patch],
        "vertex": int(patches.vertices[patch]),
        **interval_content("mean_f1", utility.mean[patch], utility.mean_low[patch], utility.mean_high[patch]),
        **interval_content("expected_f1", *utility.expected.at(patch)),
        "rank_interval": [int(utility.rank_low[patch]), int(utility.rank_high[patch])],
        "f1": dict(zip(utility.activities, map(rounded, utility.f1[patch]), strict=True)),
    }


def rounded(value: float) -> float:
    """Rounded as numbers are written to files."""
    return round(float(value), DIGITS)
