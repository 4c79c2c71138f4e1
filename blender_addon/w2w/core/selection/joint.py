# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen by the classifier that will be worn, and what such a set would reach on other clips."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..ranking.weights import mean_over
from ..threads import unthreaded_products
from .constraints import Terms, fewest
from .promise import Promise, Promises
from .set_tests import SetTests, Tests

LARGEST_SET = 6
"""Sensors up to which sets are grown."""

FIRST_SETS = 3
"""Sensors up to which they are grown at first; more where more is wanted and may help."""

WORTH = 0.01
"""Expected F1 that all sensors added must promise together, where the target is out of reach."""

ROUNDING = 1e-6
"""F1 differences smaller than this are rounding."""

SHORTLIST = 0.25
"""Share of the candidates that stay candidates once they have been tried beside the patches worn."""

LEAST_LISTED = 32
"""No fewer of them: on 826 clips the best for the next patch was left out once in 20, and missed by an area
of .0002."""

OF_HALVES = 128
"""Candidates that a half chooses among: the first patches, which were sampled to lie far apart."""


class Growth(NamedTuple):
    """A set that grows."""

    order: tuple[int, ...] = ()  # its patches, in order of choice
    shortlist: np.ndarray | None = None  # candidates for further patches; None as long as all are


def grow(
    tests: Tests,
    terms: Terms,
    size: int,
    first: np.ndarray | None = None,
    worst: bool = False,
    among: int | None = None,
    start: Growth | None = None,
) -> Growth:
    """Add patches up to a size, each time the one with which the classifier tells activities apart best.

    The first is chosen by `first` (N,), `tests.single` by default. Of the candidates tried, the best stay
    candidates for further patches; all do where the activity told apart `worst` decides, not the mean, for
    that is another activity each time. `among` is how many candidates are looked at, all by default.
    """
    chosen, shortlist = start or Growth()
    order = list(chosen)
    with unthreaded_products():
        area = float(tests.added(order[:-1], np.array(order[-1:]), worst)[0]) if len(order) > 1 else 0.0
        while len(order) < min(size, terms.max_size):
            missing = [options for options in terms.required if not np.isin(order, options).any()]
            free = np.flatnonzero(terms.allowed) if shortlist is None else shortlist
            candidates = (missing[0] if missing else np.setdiff1d(free, order))[:among]
            if not len(candidates):
                break
            if order:
                value = tests.added(order, candidates, worst)
            else:
                value = (tests.single if first is None else first)[candidates]
            gain = (value - area) / terms.cost[candidates]
            if order and not missing and not worst:
                most = max(int(SHORTLIST * len(candidates)), LEAST_LISTED)
                shortlist = np.sort(candidates[np.argsort(-gain, kind="stable")[:most]])
            best = int(gain.argmax())
            area = float(value[best]) if order else 0.0
            order.append(int(candidates[best]))
    return Growth(tuple(order), shortlist)


class ByHalves:
    """Chooses as `grow` does, among fewer candidates; goes on from what it chose before."""

    def __init__(self, worst: bool = False) -> None:
        self._worst = worst
        self._grown: dict[Tests, Growth] = {}

    def __call__(self, half: Tests, terms: Terms, size: int) -> tuple[int, ...]:
        """Choose from the tests of a half, under the same terms each time."""
        grown = self._grown.get(half, Growth())
        if len(grown.order) < size:
            grown = grow(half, terms, size, worst=self._worst, among=OF_HALVES, start=grown)
            self._grown[half] = grown
        return grown.order[:size]


@dataclass(frozen=True, eq=False)
class JointSet:
    """A set of patches chosen to be worn together."""

    order: tuple[int, ...]  # the patches recommended, in order of choice
    promise: Promise  # of the first, the first two, and so on
    activities: tuple[str, ...]
    target: float  # expected macro F1 to reach
    every_activity: float  # least expected F1 of any activity; 0 for none
    reached: bool
    cost: float
    weights: np.ndarray  # (A,): what each activity counts
    further: tuple[int, ...] = ()  # patches that were tried after these, in order of choice
    with_next: Promise | None = None  # of these patches and the first of `further`
    tried: int = 0  # sensors up to which sets were tried
    most: float = 0.0  # expected F1 of the best of those sets

    @property
    def raw_mean(self) -> np.ndarray:
        """Macro F1 of the first patch, the first two, and so on, on the clips that chose them."""
        return mean_over(self.promise.raw, self.weights)

    def sentence(self) -> str:
        """Say in words what the set would reach on other clips."""
        made, count = self.promise, len(self.order)
        sensors = "1 sensor reaches" if count == 1 else f"{count} sensors worn together reach"
        text = (
            f"{sensors} an expected F1 of {made.mean[-1]:.3f} on other clips "
            f"(95 % interval {made.low[-1]:.2f} to {made.high[-1]:.2f}; target {self.target:.3g}"
        )
        if self.every_activity:
            worst = int(np.where(self.weights > 0, made.f1[-1], np.inf).argmin())
            text += (
                f", {self.every_activity:g} for every activity, of which {self.activities[worst]} has the "
                f"lowest, {made.f1[-1, worst]:.3f}"
            )
        if self.reached:
            return f"{text})"
        if self.tried > count:
            return f"{text}); sets of up to {self.tried} sensors promise no more than {self.most:.3f}"
        return f"{text}); no more sensors are allowed, or more add nothing"


def choose_together(
    tests: SetTests,
    expected: Sequence[np.ndarray],
    terms: Terms,
    target: float = 0.9,
    every_activity: float = 0.0,
) -> JointSet:
    """The cheapest set whose promise reaches the target, or the one beyond which it rises no more.

    The first patch is chosen by `expected`, the macro F1 (N,) of each patch alone and the bounds of its
    interval.
    """
    worst, grown = every_activity > 0, Growth()
    promises, choose = Promises(tests, terms), ByHalves(worst)
    for size in sorted({min(most, terms.max_size) for most in (FIRST_SETS, LARGEST_SET)}):
        grown = grow(tests.whole, terms, size, expected[0], worst, start=grown)
        order = grown.order
        made = promises.of(order, choose, tuple(float(values[order[0]]) for values in expected))
        enough, reached = _enough(tests, terms, target, every_activity, order, made)
        if reached or (len(order) > fewest(order, terms.required) and made.mean[-1] <= made.mean[-2]):
            break
    chosen, further = order[:enough], order[enough:]
    cost = float(terms.cost[list(chosen)].sum())
    with_next = made.first(enough + 1) if further else None
    return JointSet(
        chosen, made.first(enough), tests.activities, target, every_activity, reached, cost, tests.weights,
        further, with_next, len(order), float(made.mean[-1]),
    )  # fmt: skip


def _enough(
    tests: SetTests, terms: Terms, target: float, every_activity: float, order: Sequence[int], made: Promise
) -> tuple[int, bool]:
    """The number of patches that reach the target for the least cost, and whether they do.

    Where none do, it is the fewest that promise what the most promise but for little.
    """
    sizes = np.arange(fewest(order, terms.required), len(order) + 1)
    mean = made.mean[sizes - 1]
    lowest = made.f1[sizes - 1][:, tests.weights > 0].min(axis=1)
    good = np.minimum(mean - target, lowest - every_activity) >= -ROUNDING
    reached = bool(good.any())
    if not reached:
        good = mean >= mean.max() - WORTH
        if every_activity > 0:
            good &= lowest >= lowest[good].max() - WORTH
    return int(sizes[good.argmax()]), reached
