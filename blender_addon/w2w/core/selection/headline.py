# SPDX-License-Identifier: GPL-3.0-or-later
"""How sure an answer is, in sentences that console, report and panel share."""

import numpy as np

from ..ranking.expected import WANTED, clips_needed
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.utility import UtilityMap
from ..ranking.weights import alike
from ..wording import count

CANNOT_RANK = (
    "These clips cannot rank placements: the best spot may be no better than an average one, or halves of "
    "the clips could not be compared"
)

BELOW_AVERAGE = "No allowed spot is expected to do as well as an average one on the whole body"

WORN = {True: ".11 lower to .26 higher", False: ".19 lower to .25 higher"}
"""Range of measured minus expected F1 on four data sets' worn sensors, by whether subjects were left out."""

FAR = 10.0
"""Factor on the number of clips above which a prediction would be a guess."""


def as_good_as(best: int, utility: UtilityMap, allowed: np.ndarray | None = None) -> np.ndarray:
    """Numbers of the allowed patches that tie with the best of all; `best` alone if it does not tie."""
    group = utility.as_good if allowed is None else utility.as_good & allowed
    return np.flatnonzero(group) if utility.as_good[best] else np.array([best])


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


def spot_caution(best: int, utility: UtilityMap) -> str:
    """Why the recommended patch may be no better than an average one; "" if it is."""
    if not utility.can_rank:
        return CANNOT_RANK
    return BELOW_AVERAGE if utility.expected_mean[best] < utility.expected_mean.mean() else ""


def confidence_sentence(utility: UtilityMap, best: int | None = None) -> str:
    """The best spot's lead over an average one, its chance, and the repeatability of F1 itself.

    `best` is the best allowed patch, if not all are allowed.
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
    more = more_clips(utility)
    if more is None:
        units = "subjects" if utility.by_subject else "clips"
        return f"{text}; more than {FAR:g} times as many {units} would make it good"
    if utility.by_subject:
        return f"{text}; about {factor:.1f} times as many subjects would make it good"
    return f"{text}; about {count('more clip', more)} for each activity would make it good"


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
    name = utility.activities[counts.index(fewest)]
    return f"from only {count('clip', fewest)} of {name}: too few for an interval"


def short(value: float) -> str:
    """The value with two decimals, without a leading zero."""
    return f"{value:.2f}".replace("0.", ".", 1) if abs(value) < 0.995 else f"{value:.2f}"
