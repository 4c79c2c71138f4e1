# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of a ranking in words, for lists, cards and notes: from the values that a summary holds."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..imu.cover import HAS_CAUGHT
from ..ranking.costs import IS_AS_GOOD, costs_at, is_as_good
from ..ranking.utility import UtilityMap
from ..selection import headline
from ..selection.headline import mean_caution, short
from ..wording import capital, count, join_words

Content = Mapping[str, Any]


def as_sentence(text: str) -> str:
    """A text with a capital at its beginning and one full stop at its end."""
    return f"{capital(text.removesuffix('.'))}."


def sure_sentences(answer: Content, utility: UtilityMap) -> list[str]:
    """Sentences that say how sure an answer is."""
    said = (answer.get(name, "") for name in ("detail", "measured"))
    sentences = (*said, headline.mean_sentence(utility), headline.repeat_sentence(utility))
    return [as_sentence(sentence) for sentence in sentences if sentence]


def product_row(product: Content) -> tuple[str, str]:
    """A product with its side, and its F1 with what it costs against the recommended place."""
    name, f1 = capital(f"{product['side']} {product['name']}".strip()), short(product["expected_f1"])
    if product["verdict"] == IS_AS_GOOD:
        return name, f1
    return name, f"{f1}, {'may cost' if product['verdict'] else 'costs'} {short(product['costs'])}"


def placement_row(scores: Content | None, patch: int) -> str:
    """A placement of the user's in a row of a list, by its `own_scores` and its patch, -1 without one."""
    if scores is None:
        return "new" if patch < 0 else "not ranked"
    return f"{scores['expected_f1']:.2f}   {scores['rank']} of {scores['of']}"


def placement_sentence(scores: Content, utility: UtilityMap) -> str:
    """The `own_scores` of a placement in a sentence."""
    low, high = scores["expected_f1_interval"]
    interval = mean_caution(utility) or f"{low:.2f} to {high:.2f}"
    loss = scores["verdict"] or f"costs {short(scores['costs'])}"
    rank = f"rank {scores['rank']} of {scores['of']} among the sampled spots"
    score = f"expected F1 {scores['expected_f1']:.3f} ({interval})"
    return f"{scores['region'].capitalize()}: {score}, {rank}, {loss}."


def patch_lines(
    patch: int, utility: UtilityMap, expected: np.ndarray, raw: np.ndarray, base: Sequence[int], ranked: bool
) -> tuple[str, str]:
    """A patch's scores in words: what other clips would show, then what these showed.

    `expected` and `raw` are the scores of all patches (N,); `ranked` is whether activities count in them as
    they did in the ranking. Costs are against a sensor on the patches `base`.
    """
    rank = f"rank {1 + int((expected > expected[patch]).sum())} of {len(expected)}"
    score, these = f"expected F1 {expected[patch]:.2f}", f"on these clips {raw[patch]:.2f}"
    if not ranked:
        return f"{score} over the activities that count", f"{rank}; {these}"
    equal = ", as good" if base and is_as_good(costs_at(utility, base)[patch]) else ""
    if mean_caution(utility):
        return f"{score} (too few clips for an interval)", f"{rank}{equal}; {these}"
    _, low, high = utility.expected.at(patch)
    raw_low, raw_high = utility.mean_low[patch], utility.mean_high[patch]
    first = f"{score} ({low:.2f} to {high:.2f}){equal}"
    return first, f"{rank}; {these} ({raw_low:.2f} to {raw_high:.2f})"


def may_move(card: Content) -> str:
    """How far a sensor may slip and turn, by its card; "" if that is not known."""
    far = {" cm": card.get("slip_cm"), "°": card.get("turn_deg")}
    return ", ".join(f"{limit:.0f}{unit}" for unit, limit in far.items() if limit is not None)


def sensor_sentences(
    label: str, f1: Sequence[float], card: Content, others: Sequence[str], utility: UtilityMap
) -> Iterator[str]:
    """A sensor of a set: F1 up to it with its interval, where it goes, what it needs, where else."""
    about = mean_caution(utility) or f"{short(f1[1])} to {short(f1[2])}"
    yield f"{label}. F1 with the sensors so far: {short(f1[0])} ({about}). {card.get('in_words', '')}"
    if needs := card.get("needs", {}).get("sentence"):
        yield f"{needs}."
    if others:
        yield f"Or instead: {' or '.join(others)}."


def pilot_sentences(pilot: Content) -> list[str]:
    """What a pilot says (`Pilot.content`): its level, what speaks against it, what is next and left out."""
    left = join_words([": ".join(map(str, each)) for each in pilot.get("skipped", ())])
    cautions = [each["text"] for each in pilot["cautions"]]
    said = (pilot["sentence"], *cautions, pilot["next"], left and f"left out: {left}")
    return [as_sentence(text) for text in said if text]


def baked_sentence(paths: Mapping[str, str], patches: int, failed: Sequence[str]) -> str:
    """What was baked of some clips, by the path that each took, and what failed with the reasons."""
    text = f"Baked {count('clip', len(paths) - len(failed))} on {patches} spots"
    if general := sum(path.startswith("general") for path in paths.values()):
        text += f", {general} by Blender's evaluated mesh"
    if caught := [clip for clip, path in paths.items() if HAS_CAUGHT in path]:
        text += f". {capital(HAS_CAUGHT)} in {join_words(caught, 2)}: do not trust its signals there"
    return f"{text}. Not baked: {join_words(failed, 2)}" if failed else text
