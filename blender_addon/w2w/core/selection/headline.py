# SPDX-License-Identifier: GPL-3.0-or-later
"""The outcome in a sentence or two, the same on the console, in the report and in Blender's panel."""

from __future__ import annotations

import numpy as np

from ..patches.body_parts import SIDES, great_part, segment
from ..patches.patches import PatchSet
from ..ranking.expected import WANTED, clips_needed
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.utility import UtilityMap
from ..ranking.weights import alike
from ..wording import capital

CANNOT_RANK = (
    "These clips cannot rank placements: the best spot may be no better than an average one, or halves of "
    "the clips could not be compared"
)

BELOW_AVERAGE = "No allowed spot is expected to do as well as an average one on the whole body"

NAMED = 3
"""Most parts of the body that a sentence names."""

WORN = {True: ".11 lower to .26 higher", False: ".19 lower to .25 higher"}
"""Range of measured less expected F1 on four data sets' worn sensors, by whether subjects were left out."""

FAR = 10.0
"""Times as many clips beyond which a number would be a guess."""


def as_good_as(best: int, utility: UtilityMap, allowed: np.ndarray | None = None) -> np.ndarray:
    """Numbers of the allowed patches as good as the best of all; `best` alone where it is not."""
    group = utility.as_good if allowed is None else utility.as_good & allowed
    return np.flatnonzero(group) if utility.as_good[best] else np.array([best])


def best_spot_sentence(
    best: int, utility: UtilityMap, patches: PatchSet, allowed: np.ndarray | None = None
) -> str:
    """Where to wear one sensor and its expected F1 on other clips: one patch, or all that are as good.

    `best` is the patch of highest expected F1 of those `allowed` (N,), bool; all are by default.
    """
    return f"{where_to_wear(best, utility, patches, allowed)}, {score_text(best, utility)}"


def where_to_wear(
    best: int, utility: UtilityMap, patches: PatchSet, allowed: np.ndarray | None = None
) -> str:
    """The first half of `best_spot_sentence`: the patch, or the parts of the body that are as good."""
    group = as_good_as(best, utility, allowed)
    n_allowed = len(patches) if allowed is None else int(allowed.sum())
    if len(group) == 1:
        where = f"{patches.names[best]} ({_alone(best, utility, allowed)})"
    elif len(group) == n_allowed:
        place = "anywhere on the body" if n_allowed == len(patches) else "anywhere that is allowed"
        where = f"{place} (all {len(group)} patches are as good)"
    else:
        where = f"{_parts(group, utility.expected_mean, patches)} ({len(group)} patches are as good)"
    return capital(where)


def score_text(best: int, utility: UtilityMap) -> str:
    """The second half: the patch's expected F1 on other clips."""
    low, high = utility.expected_low[best], utility.expected_high[best]
    interval = mean_caution(utility) or f"95 % interval {short(low)} to {short(high)}"
    others = "other people" if utility.by_subject else "other clips"
    return f"expected mean F1 {short(utility.expected_mean[best])} on {others} ({interval})"


def mean_title(utility: UtilityMap) -> str:
    """Title of the map of the mean."""
    return "All activities (mean)" if alike(utility.weights) else "Activities that count (mean)"


def mean_sentence(utility: UtilityMap) -> str:
    """The activities that the mean is over and their weights; empty where all count alike."""
    if alike(utility.weights):
        return ""
    listed = list(zip(utility.activities, utility.weights.tolist(), strict=True))
    background = [name for name, weight in listed if not weight]
    counted = [(name, weight) for name, weight in listed if weight]
    if len({weight for _, weight in counted}) == 1:
        names = [name for name, _ in counted]
        text = f"The mean is over {len(names)} of {len(listed)} activities ({', '.join(names)})"
    else:
        weighed = ", ".join(f"{name} {weight:g}" for name, weight in counted)
        text = f"The mean over {len(counted)} activities is weighted ({weighed})"
    if not background:
        return text
    return f"{text}; background, trained against and not counted: {', '.join(background)}"


def spot_caution(best: int, utility: UtilityMap) -> str:
    """Why the recommended patch may be no better than an average one; empty where it is."""
    if not utility.can_rank:
        return CANNOT_RANK
    return BELOW_AVERAGE if utility.expected_mean[best] < utility.expected_mean.mean() else ""


def confidence_sentence(utility: UtilityMap, best: int | None = None) -> str:
    """The best spot's lead over an average one, its chance, and the repeatability of F1 itself.

    `best` is the best allowed patch, where not all are.
    """
    worn = f"On people's sensors, four data sets, F1 came out {WORN[utility.by_subject]} (docs/truth.md)"
    return f"{_confidence(utility, best)}. {worn}"


def _confidence(utility: UtilityMap, best: int | None) -> str:
    if np.isnan(utility.reliability) and not len(utility.half_f1 if utility.half_f1 is not None else ()):
        return (
            "How sure this is cannot be told: halves of these clips could not be compared. That takes four "
            "clips an activity, two subjects where subjects are left out, and the classifier ridge"
        )
    mean = utility.expected_mean
    gain = short(float(mean.max() - mean.mean()))
    chance = min(round(100 * utility.beats_average), 99)
    spot = "The best spot" if best is None or mean[best] == mean.max() else "The best spot anywhere"
    text = f"{spot} beats an average one on other clips by about {gain} ({chance} % sure)"
    if np.isnan(utility.reliability):
        return text
    text += f". Patch by patch, F1 repeats at {short(utility.reliability)} (good from {short(WANTED)})"
    factor = clips_needed(utility.reliability)
    if factor <= 1:
        return text
    if factor > FAR:
        units = "subjects" if utility.by_subject else "clips"
        return f"{text}; more than {FAR:g} times as many {units} would make it good"
    if utility.by_subject:
        return f"{text}; about {factor:.1f} times as many subjects would make it good"
    count = more_clips(utility)
    return f"{text}; about {count} more clip{'' if count == 1 else 's'} for each activity would make it good"


def more_clips(utility: UtilityMap) -> int | None:
    """Further clips of an activity with the median number that would make the map reliable.

    None where that is not known, or more than `FAR` times as many would be needed.
    """
    factor = clips_needed(utility.reliability)
    if not factor <= FAR:
        return None
    return int(np.ceil(max(factor - 1, 0.0) * np.median(utility.tested_clips())))


def mean_caution(utility: UtilityMap) -> str:
    """A caution in place of the mean's interval, where no activity has clips enough for one; else empty."""
    most = max(utility.tested_clips())
    return f"from at most {most} clips per activity: too few for an interval" if most < FEWEST_CLIPS else ""


def short(value: float) -> str:
    """Two decimals without the leading nought."""
    return f"{value:.2f}".replace("0.", ".", 1) if abs(value) < 0.995 else f"{value:.2f}"


def _alone(best: int, utility: UtilityMap, allowed: np.ndarray | None) -> str:
    if utility.as_good[best]:
        return (
            "no other patch is as good" if allowed is None or allowed.all() else "no other allowed patch is"
        )
    return f"the best patch anywhere would give {short(utility.expected_mean.max())}"


def _parts(group: np.ndarray, expected: np.ndarray, patches: PatchSet) -> str:
    """The parts of the body that hold most of a group, both sides as one: small ones, or great.

    First those whose patches add up to most above the group's lowest: where the highest of equals lies, noise
    decides.
    """
    above = expected[group] - expected[group].min()
    for part_of in (segment, great_part):
        found = [part_of(patches.regions[patch]) for patch in group.tolist()]
        stems = np.array([part.removeprefix("left ").removeprefix("right ") for part in found])
        held = {stem: above[stems == stem] for stem in stems.tolist()}
        order = sorted(held, key=lambda stem: (-held[stem].sum(), -len(held[stem]), stem))
        so_far = np.cumsum([len(held[stem]) for stem in order])
        named = int(np.flatnonzero(2 * so_far > len(group))[0]) + 1
        if named <= NAMED:
            break
    named = min(named, NAMED)
    rest = len(order) - named
    sides = (" and ".join(side for side in SIDES if f"{side} {stem}" in found) for stem in order)
    names = [f"{side} {stem}".strip() for side, stem in zip(sides, order[:named], strict=False)]
    names += [f"{rest} other part{'' if rest == 1 else 's'} of the body"] if rest else []
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
