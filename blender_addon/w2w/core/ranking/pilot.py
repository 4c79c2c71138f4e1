# SPDX-License-Identifier: GPL-3.0-or-later
"""A map's level by a pilot: what F1 worn at a place or two says of all others, and how far it may be off.

Rule and constants were frozen before they met the people they were tested on (docs/evidence/pilot.md).
"""

from collections.abc import Sequence

import numpy as np
import scipy

from .f1 import window_f1

SHARE = 0.8
"""Share of each activity's difference at the worn places that is taken over everywhere."""

ERRORS_LEFT = {2: 0.6, 3: 0.85}
"""Of so many people each is tested on a classifier of one or two others: what more people leave of 1 - F1."""

LEFT_OPEN = {1: 0.18, 2: 0.165}
"""Half of the 90 % interval at a place that was not worn, by how many were, without the people's spread."""

OF_TWO = 0.2
"""The same for two people."""

LEVEL = 0.9
"""Confidence of a pilot's intervals."""


def learned(worn: np.ndarray, people: int) -> np.ndarray:
    """F1 that was worn as more people would show it, from that of so many."""
    return 1 - (1 - worn) * ERRORS_LEFT.get(people, 1.0)


def levelled(expected: np.ndarray, difference: np.ndarray) -> np.ndarray:
    """F1 (N, A) expected everywhere, by how far it differs at the worn places (A,), worn less expected."""
    return np.clip(expected + SHARE * difference, 0, 1)


def half_width(by_person: np.ndarray, places: int, at_worn: bool = False) -> float:
    """Half of the 90 % interval of macro F1 at a place.

    `by_person` (P,): macro F1 of each person, the mean over the worn places.
    """
    people = len(by_person)
    if at_worn:
        reach = scipy.special.stdtrit(people - 1, (1 + LEVEL) / 2)
        return float(reach * by_person.std(ddof=1) / np.sqrt(people))
    return width_with(float(by_person.std(ddof=1)), people, places)


def width_with(spread: float, people: int, places: int) -> float:
    """The same where so many people whose F1 spreads so far wore so many places."""
    site = OF_TWO if people == 2 else LEFT_OPEN[min(places, max(LEFT_OPEN))]
    return float(np.hypot(site, scipy.special.ndtri((1 + LEVEL) / 2) * spread / np.sqrt(people * places)))


def by_chance(truth: np.ndarray, predicted: np.ndarray, unit: Sequence[str], n_activities: int) -> float:
    """Macro F1 that one of twenty draws of labels among the clips reaches, with these predictions.

    `truth`, `predicted` (W,) of int; `unit` (W,): clip of each window.
    """
    rng = np.random.default_rng(0)
    _, first, of = np.unique(unit, return_index=True, return_inverse=True)
    drawn = [macro_f1(rng.permutation(truth[first])[of], predicted, n_activities) for _ in range(200)]
    return float(np.quantile(drawn, 0.95))


def macro_f1(truth: np.ndarray, predicted: np.ndarray, n_activities: int) -> float:
    """Macro F1 over the activities that are shown."""
    f1 = window_f1(predicted, truth, n_activities)
    return float(f1[~np.isnan(f1)].mean())
