# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen by the classifier that will be worn, and what such a set would reach on other clips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from .promise import Promise, promise
from .set_tests import SetTests, Tests
from .subsets import ROUNDING
from .terms import Terms, fewest

LARGEST_SET = 6
"""Sensors up to which sets are grown."""

FIRST_SETS = 3
"""Sensors up to which they are grown at first; more where more is wanted and may help."""

OF_HALVES = 128
"""Candidates that a half chooses among: the first of the patches, which lie as far apart as may be."""


def grow(
    tests: Tests,
    terms: Terms,
    size: int,
    first: np.ndarray | None = None,
    worst: bool = False,
    among: int | None = None,
    start: Sequence[int] = (),
) -> tuple[int, ...]:
    """Add the patch by which the classifier on all of them tells the activities apart best.

    Parameters
    ----------
    tests : Tests
    terms : Terms
        What may and must be chosen, and what it costs.
    size : int
    first : ndarray, shape (N,), optional
        What the first patch is chosen by; `tests.single` by default.
    worst : bool
        Whether the activity told apart worst decides, not the mean.
    among : int, optional
        How many candidates are looked at; all by default.
    start : sequence of int
        Chosen already.

    Returns
    -------
    tuple of int
        In order of choice.
    """
    order = list(start)
    with threadpool_limits(1):
        area = float(tests.added(order[:-1], np.array(order[-1:]), worst)[0]) if len(order) > 1 else 0.0
        while len(order) < min(size, terms.max_size):
            missing = [options for options in terms.required if not np.isin(order, options).any()]
            candidates = missing[0] if missing else np.setdiff1d(np.flatnonzero(terms.allowed), order)
            candidates = candidates[:among]
            if not len(candidates):
                break
            if order:
                value = tests.added(order, candidates, worst)
            else:
                value = (tests.single if first is None else first)[candidates]
            best = int(((value - area) / terms.cost[candidates]).argmax())
            area = float(value[best]) if order else 0.0
            order.append(int(candidates[best]))
    return tuple(order)


def chosen_by_halves(half: Tests, terms: Terms, size: int, worst: bool = False) -> tuple[int, ...]:
    """Choose as `grow` does, among fewer candidates; goes on from what was chosen under the same terms."""
    terms_before, worst_before, before = half.grown
    start = before if terms_before is terms and worst_before == worst else ()
    if len(start) < size:
        half.grown = terms, worst, grow(half, terms, size, worst=worst, among=OF_HALVES, start=start)
    return half.grown[2][:size]


@dataclass(frozen=True, eq=False)
class JointSet:
    """A set of patches chosen to be worn together.

    Attributes
    ----------
    order : tuple of int
        In order of choice, as many as are recommended.
    promise : Promise
        Of the first, the first two, and so on.
    activities : tuple of str
    target : float
        Expected macro F1 to reach.
    every_activity : float
        Expected F1 that no activity may fall short of; 0 for none.
    reached : bool
    cost : float
    """

    order: tuple[int, ...]
    promise: Promise
    activities: tuple[str, ...]
    target: float
    every_activity: float
    reached: bool
    cost: float

    def sentence(self) -> str:
        """Say in words what the set would reach on other clips."""
        made, count = self.promise, len(self.order)
        sensors = "1 sensor reaches" if count == 1 else f"{count} sensors worn together reach"
        text = (
            f"{sensors} an expected F1 of {made.mean[-1]:.3f} on other clips "
            f"(95 % interval {made.low[-1]:.2f} to {made.high[-1]:.2f}; target {self.target:g}"
        )
        if self.every_activity:
            worst = int(made.f1[-1].argmin())
            text += (
                f", {self.every_activity:g} for every activity, of which {self.activities[worst]} has the "
                f"lowest, {made.f1[-1, worst]:.3f}"
            )
        return text + (")" if self.reached else "); no more sensors are allowed, or more add nothing")


def choose_together(
    tests: SetTests,
    expected: Sequence[np.ndarray],
    terms: Terms,
    target: float = 0.9,
    every_activity: float = 0.0,
) -> JointSet:
    """The smallest set whose promise reaches the target, or the one beyond which it rises no more.

    Parameters
    ----------
    tests : SetTests
    expected : three ndarrays, shape (N,)
        Expected macro F1 of each patch alone, by which the first is chosen, and its interval.
    terms : Terms
    target : float
    every_activity : float

    Returns
    -------
    JointSet
    """
    worst, order = every_activity > 0, ()
    choose = partial(chosen_by_halves, worst=worst)
    for size in sorted({min(most, terms.max_size) for most in (FIRST_SETS, LARGEST_SET)}):
        order = grow(tests.whole, terms, size, expected[0], worst, start=order)
        made = promise(tests, terms, order, choose, tuple(float(values[order[0]]) for values in expected))
        least = fewest(order, terms.required)
        good = (made.mean >= target - ROUNDING) & (made.f1.min(axis=1) >= every_activity - ROUNDING)
        good[: least - 1] = False
        if good.any() or (len(order) > least and made.mean[-1] <= made.mean[-2]):
            break
    enough = int(good.argmax()) + 1 if good.any() else max(least, int(made.mean.argmax()) + 1)
    order = order[:enough]
    return JointSet(
        order,
        made.first(enough),
        tests.activities,
        target,
        every_activity,
        bool(good.any()),
        float(terms.cost[list(order)].sum()),
    )
