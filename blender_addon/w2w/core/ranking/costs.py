# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of one place against another: what it loses of expected F1, and whether it is as good."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from .utility import UtilityMap

AS_GOOD = 0.02
"""Largest expected cost of a place that is as good as another."""

KEPT = 0.03
"""Largest expected lead over what people wear anyway that leaves that the answer (docs/evidence/habit.md)."""

EQUAL = 0.0025
"""Expected F1 by which places differ no more than another seed of the folds makes them differ."""

IS_AS_GOOD = "as good"
"""The verdict on such a place."""

MOMENT = 0.1
"""Least gain over a habit that is said, as people are told F1 in moments of ten."""

MAY_COST = "may cost"
"""The verdict on a place of which these clips cannot show that it costs."""

DOUBTFUL = 1.4
"""Factor on errors between people, and of few clips: halves of those show too little of them."""

UNHALVED = 0.1
"""Error of a difference of two places where too few clips can be halved: found on drawn libraries."""

LEAST_PAIR = 1 / 16
"""Least variance of one pair of places, of that of any two: few halvings may show none by chance."""


class Cost(NamedTuple):
    """Expected F1 that a sensor loses at one place against another, on other clips."""

    expected: float
    low: float  # bounds of what as many other clips show
    high: float

    @property
    def as_good(self) -> bool:
        """Whether the place is as good."""
        return bool(is_as_good(self.expected))

    @property
    def may(self) -> bool:
        """Whether it is expected to cost more than `AS_GOOD`, and these clips cannot show that it costs."""
        return not self.as_good and self.low <= 0

    def verdict(self) -> str:
        """Whether it is as good, in words; "" if it is shown that it does not."""
        return IS_AS_GOOD if self.as_good else MAY_COST if self.may else ""


def as_shown(f1: Any) -> Any:
    """F1, or differences of it, by the two digits that are shown: what is not shown decides nothing."""
    return np.round(f1, 2)


def is_as_good(costs: Any) -> Any:
    """Whether places are as good as another, by what they cost against it."""
    return as_shown(costs) <= AS_GOOD


def costs_at(utility: UtilityMap, base: Sequence[int]) -> np.ndarray:
    """Expected costs of a sensor at each patch, shape (N,), against one on the patches `base`, as shown."""
    return as_shown(utility.expected_mean[list(base)].mean()) - as_shown(utility.expected_mean)


def cost_of(utility: UtilityMap, base: Sequence[int], place: Sequence[int]) -> Cost:
    """The cost of a sensor that moves over the patches `place` against one that moves over `base`.

    The interval is that of the difference on as many other clips. Its variance is the geometric mean of that
    which halves of the clips show for these two places and for any two: few halvings tell little of one pair.
    """
    base, place = list(base), list(place)
    here, there = (as_shown(utility.expected_mean[some].mean()) for some in (base, place))
    return judged(float(here - there), _reach(utility, base, place))


def gain(utility: UtilityMap, place: Sequence[int], other: Sequence[int]) -> Cost:
    """What another place costs against one chosen by these clips: the lead, less the luck that is in it."""
    here, there = list(place), list(other)
    lead = float(utility.expected_mean[here].mean() - utility.expected_mean[there].mean())
    reach = _reach(utility, here, there)
    error = reach / scipy.special.ndtri((1 + utility.level) / 2)
    counted = lead**3 / (lead**2 + error**2) if lead else 0.0
    return judged(counted, reach)


def _reach(utility: UtilityMap, base: list[int], place: list[int]) -> float:
    """Half of the interval of the difference of two places."""
    if base == place:
        return 0.0
    reach = reach_of(np.array([UNHALVED]), UNHALVED**2, utility.level)
    if utility.halved:
        of_pair = utility.errors[:, base].mean(axis=1) - utility.errors[:, place].mean(axis=1)
        reach = reach_of(of_pair, 2 * np.square(utility.errors).mean(), utility.level)
    return reach * DOUBTFUL if utility.doubtful else reach


def reach_of(of_pair: np.ndarray, of_any: float, level: float) -> float:
    """Half of the interval of a difference, from its errors in halves (E,) and the variance of any two's."""
    variance = np.sqrt(max(np.square(of_pair).mean(), LEAST_PAIR * of_any) * of_any)
    return float(scipy.special.ndtri((1 + level) / 2) * np.sqrt(variance))


def judged(expected: float, reach: float) -> Cost:
    """The cost with its interval."""
    return Cost(expected, max(expected - reach, -1.0), min(expected + reach, 1.0))
