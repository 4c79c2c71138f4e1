# SPDX-License-Identifier: GPL-3.0-or-later
"""Does a run's advice hold for other clips? Disjoint halves choose, and each other's raw F1 judges."""

from dataclasses import replace

import numpy as np
from scipy.stats import spearmanr

from w2w.core.ranking.halves import deal_halves
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import WindowLabels
from w2w.core.windows.inputs import PatchBlocks, SomeWindows

FEWEST_MOTIONS = 4
"""Motions of an activity of which each half has two, to train on one and test on the other."""

FIGURES = ("expected", "delivered", "gain", "by raw F1", "rho", "ceiling", "stated", "did", "holds")
"""For a choice: F1 expected of the chosen patch and its raw F1 on the other half; how much that is above an
average patch's, and the same of the patch of the highest raw F1; Spearman's rho of the expected map with
the other half's raw map, and the root of the raw maps'; the stated chance of beating an average patch,
whether it did, and the share of patches whose interval holds the other half's F1."""


def choices(
    inputs: PatchBlocks,
    labels: WindowLabels,
    config: StudyConfig,
    pooling: Pooling | None,
    halvings: int,
    by_subject: bool,
) -> np.ndarray:
    """Figures of every choice, both ways of each halving, shape (2 * halvings, figures).

    Halves share no motion, or no subject. Raises ValueError if there is too little to halve.
    """
    names, code = np.unique(labels.activity, return_inverse=True)
    motions = [len(np.unique(labels.motion[code == number])) for number in range(len(names))]
    rows = np.flatnonzero(np.array(motions)[code] >= FEWEST_MOTIONS)
    some, config = labels.some(rows), replace(config, by_subject=by_subject)
    code = np.unique(some.activity, return_inverse=True)[1]
    if not len(rows) or code.max() == 0 or (by_subject and len(np.unique(some.subject)) < FEWEST_MOTIONS):
        raise ValueError(
            f"halves need two activities of {FEWEST_MOTIONS} motions or more each"
            + f", and {FEWEST_MOTIONS} subjects" * by_subject
        )
    unit = (np.zeros_like(code), some.subject) if by_subject else (code, some.motion)
    found = []
    for side in deal_halves(*unit, config.seed, halvings):
        maps = []
        for half in (side, ~side):
            protocol = some.some(half).protocol(config)
            maps.append(
                utility_map(SomeWindows(inputs, rows[half]), protocol, config.classifier, pooling=pooling)
            )
        found += [_judged(*maps), _judged(*maps[::-1])]
    return np.array(found)


def _judged(here: UtilityMap, there: UtilityMap) -> tuple[float, ...]:
    """`FIGURES` of what one half chooses."""
    best, average = int(here.expected_mean.argmax()), there.mean.mean()
    delivered = there.mean[best]
    return (
        here.expected_mean[best],
        delivered,
        delivered - average,
        there.mean[here.mean.argmax()] - average,
        _rho(here.expected_mean, there.mean),
        np.sqrt(max(_rho(here.mean, there.mean), 0.0)),
        here.beats_average,
        float(delivered > average),
        ((here.expected_low <= there.mean) & (there.mean <= here.expected_high)).mean(),
    )


def _rho(one: np.ndarray, other: np.ndarray) -> float:
    return float(spearmanr(one, other)[0]) if np.ptp(one) > 0 and np.ptp(other) > 0 else np.nan
