# SPDX-License-Identifier: GPL-3.0-or-later
"""How sure an answer is, in sentences that console, report and panel share."""

import numpy as np

from ..ranking.costs import as_shown
from ..ranking.expected import LIKELY, WANTED, clips_needed
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.utility import ExpectedF1, UtilityMap
from ..ranking.weights import alike, mean_over
from ..wording import count

WORN = ".11 lower to .24 higher"
"""Range of measured against expected F1, performers left out, on worn sensors of four data sets: the level in
docs/evidence/people.md, to which a test holds it."""

FAR = 10.0
"""Factor on the number of clips above which a prediction would be a guess."""


def mean_title(utility: UtilityMap) -> str:
    """Title of the map of the mean."""
    return "All activities (mean)" if alike(utility.weights) else "Activities that count (mean)"


def mean_sentence(utility: UtilityMap) -> str:
    """A sentence on the activities in the mean and their weights; "" if all weigh the same."""
    if alike(utility.weights):
        return ""
    pairs = list(zip(utility.activities, utility.weights.tolist(), strict=True))
    background = [name for name, weight in pairs if not weight]
    counted = [(name, weight) for name, weight in pairs if weight]
    if len({weight for _, weight in counted}) == 1:
        names = [name for name, _ in counted]
        text = f"The mean is over {len(names)} of {len(pairs)} activities ({', '.join(names)})"
    else:
        weighed = ", ".join(f"{name} {weight:g}" for name, weight in counted)
        text = f"The mean over {len(counted)} activities is weighted ({weighed})"
    if not background:
        return text
    return f"{text}; background, trained against and not counted: {', '.join(background)}"


def doubt(utility: UtilityMap) -> str:
    """How little the clips tell places apart; "" if they do."""
    if utility.can_rank:
        return ""
    return f"These clips {'hardly' if utility.beats_average >= LIKELY else 'do not'} tell places apart"


def doubted(utility: UtilityMap, text: str) -> str:
    """A text about the best place, after how little the clips tell places apart."""
    return ". ".join(filter(None, [doubt(utility), text]))


def repeat_sentence(utility: UtilityMap, simulated: bool = True) -> str:
    """How far the map repeats, what would make it reliable, and how worn sensors compared, if simulated."""
    if not simulated:
        return _reliability(utility).removesuffix(". ")
    worn = f"On people's sensors, four data sets, F1 was {WORN} than expected of other people"
    return f"{_reliability(utility)}{worn} (docs/truth.md)"


def _reliability(utility: UtilityMap) -> str:
    if not utility.halved:
        return (
            "How sure this is cannot be told: halves of these clips could not be compared. That takes four "
            "clips an activity, two subjects where subjects are left out, and the classifier ridge. "
        )
    if np.isnan(utility.reliability):
        return ""
    text = f"Map reliability {short(utility.reliability)} (aim for {short(WANTED)})"
    factor, more = clips_needed(utility.reliability), more_clips(utility)
    if more is None:
        text += f"; it takes more than {FAR:g} times as many {'subjects' if utility.by_subject else 'clips'}"
    elif factor > 1 and utility.by_subject:
        text += f"; it takes about {factor:.1f} times as many subjects"
    elif factor > 1:
        text += f"; it takes about {count('more clip', more)} for each activity"
    return f"{text}. "


def more_clips(utility: UtilityMap) -> int | None:
    """Further clips that an activity with the median number needs to make the map reliable.

    None if that is not known, or more than `FAR` times as many are needed.
    """
    factor = clips_needed(utility.reliability)
    if not factor <= FAR:
        return None
    return int(np.ceil(max(factor - 1, 0.0) * np.median(utility.tested_clips())))


def mean_caution(utility: UtilityMap) -> str:
    """A caution in place of the mean's interval if an activity has too few clips for one; else ""."""
    counts = utility.tested_clips()
    fewest = min(counts)
    if fewest >= FEWEST_CLIPS:
        return ""
    if max(counts) < FEWEST_CLIPS:
        return f"from at most {max(counts)} clips per activity: too few for an interval"
    name = utility.activities[counts.index(fewest)].replace("_", " ")
    return f"from only {count('clip', fewest)} of {name}: too few for an interval"


def by_posture(utility: UtilityMap, patch: int) -> float:
    """Expected macro F1 of a patch by the direction of gravity alone; NaN where it is not known."""
    if utility.posture is None:
        return np.nan
    lost = mean_over(utility.expected_f1[patch] - utility.posture[patch], utility.weights)
    return float(np.maximum(utility.expected_mean[patch] - lost, 0))


def tenths(f1: float) -> int:
    """How many moments of ten that is, for people: F1 is near the share that is recognised."""
    return int(np.floor(10 * as_shown(f1) + 0.5))


def moments(f1: ExpectedF1, interval: bool = True) -> str:
    """What an F1 means for people, with its interval if it is known and is wider than a tenth."""
    count, low, high = (tenths(value) for value in f1)
    text = "nearly all moments right" if count == 10 else f"about {count} of 10 moments right"
    return f"{text}, between {low} and {high}" if interval and low < high else text


def short(value: float) -> str:
    """The value with two decimals, without a leading zero."""
    value = round(value, 2) + 0.0  # no -0.00
    return f"{value:.2f}".replace("0.", ".", 1) if abs(value) < 1 else f"{value:.2f}"
