# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen by the classifier that will be worn, and what such a set would reach on other clips."""

from collections.abc import Sequence
from dataclasses import dataclass, field

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


class GrownSet:
    """A set that grows by the patch with which the classifier tells activities apart best.

    The first patch is chosen by `first` (N,). Of the candidates tried, the best stay candidates for further
    patches; all do where the activity told apart `worst` decides, not the mean, for that is another activity
    each time. `among` is how many candidates are looked at, all by default.
    """

    def __init__(
        self, tests: Tests, terms: Terms, first: np.ndarray, worst: bool = False, among: int | None = None
    ) -> None:
        self._tests, self._terms, self._first = tests, terms, first
        self._worst, self._among = worst, among
        self._order: list[int] = []
        self.candidates = np.flatnonzero(terms.allowed)  # for further patches
        self._area = 0.0

    def up_to(self, size: int) -> tuple[int, ...]:
        """The patches in order of choice, up to a size; fewer where no more are allowed."""
        order, terms = self._order, self._terms
        with unthreaded_products():
            while len(order) < min(size, terms.max_size):
                missing = [options for options in terms.required if not np.isin(order, options).any()]
                tried = (missing[0] if missing else np.setdiff1d(self.candidates, order))[: self._among]
                if not len(tried):
                    break
                value = self._tests.added(order, tried, self._worst) if order else self._first[tried]
                gain = (value - self._area) / terms.cost[tried]
                best = int(gain.argmax())
                if order:
                    self._area = float(value[best])
                    if not missing and not self._worst:
                        most = max(int(SHORTLIST * len(tried)), LEAST_LISTED)
                        self.candidates = np.sort(tried[np.argsort(-gain, kind="stable")[:most]])
                order.append(int(tried[best]))
        return tuple(order[:size])


@dataclass(frozen=True)
class ByHalves:
    """Chooses as all clips do, among fewer candidates; goes on from what it chose before."""

    worst: bool = False
    _grown: dict[Tests, GrownSet] = field(default_factory=dict)

    def __call__(self, half: Tests, terms: Terms, size: int) -> tuple[int, ...]:
        """Choose from the tests of a half, under the same terms each time."""
        if half not in self._grown:
            self._grown[half] = GrownSet(half, terms, half.single, self.worst, OF_HALVES)
        return self._grown[half].up_to(size)


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
    further: tuple[int, ...]  # patches that were tried after these, in order of choice
    with_next: Promise | None  # of these patches and the first of `further`
    most: float  # expected F1 of the largest set tried

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
        if self.further:
            tried = count + len(self.further)
            return f"{text}); sets of up to {tried} sensors promise no more than {self.most:.3f}"
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
    grown = GrownSet(tests.whole, terms, expected[0], every_activity > 0)
    promises, choose = Promises(tests, terms), ByHalves(every_activity > 0)
    for size in sorted({min(most, terms.max_size) for most in (FIRST_SETS, LARGEST_SET)}):
        order = grown.up_to(size)
        alone, low, high = (float(values[order[0]]) for values in expected)
        made = promises.of(order, choose, (alone, low, high))
        enough, reached = _enough(tests, terms, target, every_activity, order, made)
        if reached or (len(order) > fewest(order, terms.required) and made.mean[-1] <= made.mean[-2]):
            break
    chosen, further = order[:enough], order[enough:]
    cost = float(terms.cost[list(chosen)].sum())
    with_next = made.first(enough + 1) if further else None
    return JointSet(
        chosen, made.first(enough), tests.activities, target, every_activity, reached, cost, tests.weights,
        further, with_next, float(made.mean[-1]),
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
