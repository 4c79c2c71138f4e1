# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of one place against another: what it loses of expected F1, and whether it does as well."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from .utility import UtilityMap

AS_GOOD = 0.02
"""Largest expected cost of a place that does as well as another."""

EQUAL = 0.0025
"""Expected F1 by which places differ no more than another seed of the folds makes them differ."""

DOES_AS_WELL = "does as well"
"""The verdict on such a place."""


class Cost(NamedTuple):
    """Expected F1 that a sensor loses at one place against another, on other clips."""

    expected: float
    low: float  # bounds of what as many other clips show
    high: float
    may: bool  # it costs more than `AS_GOOD`, but these clips cannot show that

    @property
    def as_good(self) -> bool:
        """Whether the place does as well."""
        return bool(does_as_well(self.expected))

    def verdict(self) -> str:
        """Whether it does as well, in words; "" if it is shown that it does not."""
        return DOES_AS_WELL if self.as_good else "may do as well" if self.may else ""


def as_shown(f1: Any) -> Any:
    """F1, or differences of it, by the two digits that are shown: what is not shown decides nothing."""
    return np.round(f1, 2)


def does_as_well(costs: Any) -> Any:
    """Whether places do as well as another, by what they cost against it."""
    return as_shown(costs) <= AS_GOOD


def costs_at(utility: UtilityMap, base: Sequence[int]) -> np.ndarray:
    """Expected costs of a sensor at each patch, shape (N,), against one on the patches `base`."""
    return utility.expected_mean[list(base)].mean() - utility.expected_mean


def cost(utility: UtilityMap, base: Sequence[int], place: Sequence[int]) -> Cost:
    """The cost of a sensor that moves over the patches `place` against one that moves over `base`.

    The interval is that of the difference on as many other clips. Its variance is the geometric mean of that
    which halves of the clips show for these two places and for any two: few halvings tell little of one pair.
    """
    base, place = list(base), list(place)
    expected = float(costs_at(utility, base)[place].mean())
    reach = 0.0 if base == place else 1.0
    if utility.halved:
        of_pair = utility.errors[:, base].mean(axis=1) - utility.errors[:, place].mean(axis=1)
        reach = reach_of(of_pair, 2 * np.square(utility.errors).mean(), utility.level)
    return judged(expected, reach, utility.same(base, place))


def reach_of(of_pair: np.ndarray, of_any: float, level: float) -> float:
    """Half of the interval of a difference, from its errors in halves (E,) and the variance of any two's."""
    variance = np.sqrt(np.square(of_pair).mean() * of_any)
    return float(scipy.special.ndtri((1 + level) / 2) * np.sqrt(variance))


def judged(expected: float, reach: float, same: bool) -> Cost:
    """The cost with its interval; `same` is whether the same clips resampled may show no difference."""
    may = not does_as_well(expected) and same
    return Cost(expected, max(expected - reach, -1.0), min(expected + reach, 1.0), may)
