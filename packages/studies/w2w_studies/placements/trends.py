# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences such as "gestures are told best at the arms", held against a ranking: supported, or not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from w2w.core.body.body import Body
from w2w.core.body.regions import regions_of
from w2w.core.csv_tables import read_table
from w2w.core.patches.body_parts import find_patches
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.core.ranking.weights import mean_over
from w2w.core.wording import clean

from .score_table import resampled_f1

SUPPORTED, CONTRADICTED, UNDECIDED = "supported", "contradicted", "undecided"

RESAMPLES = 1000

LEVEL = 0.95
"""Confidence that the intervals of all claims hold together."""

TRAINING = 1.5
"""How much wider an interval is for the clips trained on, which the bootstrap keeps: that of five folds
by Nadeau and Bengio 2003, doi:10.1023/A:1024068626366."""


@dataclass(frozen=True)
class Claim:
    """That some activities are told better at some parts of the body than at others."""

    text: str  # the sentence
    group: str  # group of the activities that it is about; empty for all
    regions: tuple[str, ...]
    against: tuple[str, ...]
    """Parts of the body, in the words of `find_patches`; empty `against` for the rest of the body."""


@dataclass(frozen=True)
class Trend:
    """What a ranking says of a claim."""

    claim: Claim
    f1: float
    other_f1: float
    """Mean F1 over the group's activities and the patches of the regions, and of those held against them."""
    difference: float
    low: float
    high: float
    """And its interval; NaN where there is none."""
    activities: int
    clips: int
    """Tested ones of the group."""
    verdict: str  # "supported" or "contradicted" or "undecided"
    why: str = ""  # why there is no interval, or ""


def judge(
    utility: UtilityMap,
    patches: PatchSet,
    claims: Sequence[Claim],
    group_of: Mapping[str, str],
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> list[Trend]:
    """Hold claims against a ranking.

    The interval comes from a bootstrap over clips, within activities, that all patches share. Its spread is
    made larger for few clips (n / (n - 1), Student's t) and for those trained on, and its level is such
    that the intervals of all claims hold together (Bonferroni).

    `group_of`: group of each activity.
    Raises ValueError if words of a claim mean nothing on a body.
    """
    sides = [sides_of(claim, patches) for claim in claims]
    columns = [
        np.array(
            [n for n, name in enumerate(utility.activities) if claim.group in ("", group_of.get(name))], int
        )
        for claim in claims
    ]
    every = np.unique(np.concatenate([np.empty(0, int), *(side for pair in sides for side in pair)]))
    f1, drawn = resampled_f1(
        utility.truth, utility.predictions[:, every], utility.clip, len(utility.activities), resamples, seed
    )
    tail = (1 - LEVEL) / 2 / max(len(claims), 1)
    return [
        _trend(claim, utility, members, (f1, drawn), [np.searchsorted(every, side) for side in pair], tail)
        for claim, members, pair in zip(claims, columns, sides, strict=True)
    ]


def sides_of(claim: Claim, patches: PatchSet) -> tuple[np.ndarray, np.ndarray]:
    """The patches of a claim's regions, and the others held against them; none where none lies there.

    Raises ValueError if words mean nothing on a body.
    """
    inside = _places(claim.regions, patches)
    others = _places(claim.against, patches) if claim.against else np.arange(len(patches))
    return inside, np.setdiff1d(others, inside)


def _places(words: Sequence[str], patches: PatchSet) -> np.ndarray:
    found = [find_patches(patches.regions, patches.names, word) for word in words]
    return np.unique(np.concatenate([np.empty(0, dtype=int), *found]))


def _trend(
    claim: Claim,
    utility: UtilityMap,
    members: np.ndarray,
    scores: tuple[np.ndarray, np.ndarray],
    sides: Sequence[np.ndarray],
    tail: float,
) -> Trend:
    clips = sum(len(np.unique(utility.clip[utility.truth == member])) for member in members)
    free = clips - len(members)
    if free < 1 or not all(len(side) for side in sides):
        why = "too few clips" if free < 1 else "no patch lies there"
        return Trend(claim, *[float("nan")] * 5, len(members), clips, UNDECIDED, why)
    weights = utility.weights[members]
    weights = weights if weights.any() else np.ones(len(members))
    f1, drawn = (mean_over(values[..., members], weights) for values in scores)
    (here, there), (drawn_here, drawn_there) = (
        [values[..., side].mean(axis=-1) for side in sides] for values in (f1, drawn)
    )
    spread = float(np.std(drawn_here - drawn_there)) * TRAINING * np.sqrt(clips / free)
    reach = float(scipy.stats.t.ppf(1 - tail, free) * spread)
    difference = float(here - there)
    low, high = difference - reach, difference + reach
    verdict = SUPPORTED if low > 0 else CONTRADICTED if high < 0 else UNDECIDED
    return Trend(claim, float(here), float(there), difference, low, high, len(members), clips, verdict)


def check_claims(claims: Sequence[Claim], groups: Sequence[str], body: Body) -> None:
    """Refuse claims about what is not there.

    Raises ValueError if a claim's group is none of `groups`, or its words mean nothing on the body.
    """
    regions = regions_of(body)[1]
    for claim in claims:
        if claim.group and claim.group not in groups:
            known = ", ".join(groups)
            raise ValueError(f"claim '{claim.text}': no group is called '{claim.group}'; there are {known}")
        for word in (*claim.regions, *claim.against):
            try:
                find_patches(regions, (), word)
            except ValueError as error:
                raise ValueError(f"claim '{claim.text}': {error}") from error


def read_claims(path: str | Path) -> list[Claim]:
    """Read claims from a csv file: columns ``claim``, ``group``, ``regions``, ``against``.

    Several regions are separated by semicolons; an empty group means all activities, an empty ``against``
    the rest of the body.

    Raises ValueError if the file cannot be read or is not such a table; the message says which line.
    """
    claims = []
    for line, row in read_table(path, ("claim", "regions"), ("group", "against")).rows:
        regions, against = (
            tuple(word.strip() for word in row[name].split(";") if word.strip())
            for name in ("regions", "against")
        )
        if not (row["claim"] and regions):
            raise ValueError(f"{clean(path)}, line {line}: a claim needs its sentence and its regions")
        claims.append(Claim(row["claim"], row["group"], regions, against))
    if not claims:
        raise ValueError(f"{clean(path)} holds no claim")
    return claims
