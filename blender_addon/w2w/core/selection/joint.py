# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen by the classifier that will be worn, and what such a set would reach on other clips."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..ranking.stream import Stream
from ..ranking.weights import mean_over
from ..threads import unthreaded_products
from .constraints import Terms, fewest
from .promise import Promise, Promises, promise_in_stream
from .set_tests import SetTests, Tests

LARGEST_SET = 6
"""Sensors up to which sets are grown."""

FIRST_SETS = 3
"""Sensors up to which sets are grown at first; then more if more are wanted and may help."""

WORTH = 0.01
"""Expected F1 that all added sensors must promise together if the target is out of reach."""

ROUNDING = 1e-6
"""F1 differences smaller than this are rounding."""

SHORTLIST = 0.25
"""Share of the candidates that stay candidates once they have been tried with the patches worn."""

LEAST_LISTED = 32
"""Minimum shortlist. On 826 clips the best next patch was missing 1 time in 20, at a cost of .0002 in AUC."""

OF_HALVES = 128
"""Candidates of a half: the first patches, which were sampled to lie far apart."""


class GrownSet:
    """A set that grows by the patch with which the classifier separates activities best.

    The first patch is chosen by `first` (N,). The best of the candidates tried stay candidates for further
    patches; if the `worst` separated activity decides instead of the mean, all do, because the worst changes
    each time. `among` is how many candidates are tried, all by default.
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
        """The patches in order of choice, up to a size; fewer if no more are allowed."""
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
    """Chooses like all clips do, among fewer candidates; continues from its earlier choice."""

    worst: bool = False
    _grown: dict[Tests, GrownSet] = field(default_factory=dict)

    def __call__(self, half: Tests, terms: Terms, size: int) -> tuple[int, ...]:
        """Choose from the tests of a half, under the same terms each time."""
        if half not in self._grown:
            self._grown[half] = GrownSet(half, terms, half.single, self.worst, OF_HALVES)
        return self._grown[half].up_to(size)


@dataclass(frozen=True, eq=False)
class WornSet:
    """A set of patches chosen to be worn together."""

    order: tuple[int, ...]  # the patches recommended, in order of choice
    promise: Promise  # for the first, the first two, and so on, in a stream if there is one
    cut_out: Promise  # the same on clips cut out
    activities: tuple[str, ...]
    target: float  # expected macro F1 to reach
    every_activity: float  # least expected F1 of any activity; 0 for none
    reached: bool
    cost: float
    weights: np.ndarray  # (A,): what each activity counts
    further: tuple[int, ...]  # patches that were tried after these, in order of choice
    with_next: Promise | None  # for these patches and the first of `further`
    most: float  # expected F1 of the largest set tried

    @property
    def raw_mean(self) -> np.ndarray:
        """Macro F1 of the first patch, the first two, and so on, on the clips that chose them."""
        return mean_over(self.promise.raw, self.weights)

    def sentence(self) -> str:
        """Say in words what the set would reach on other clips."""
        promise, count = self.promise, len(self.order)
        sensors = "1 sensor reaches" if count == 1 else f"{count} sensors worn together reach"
        text = (
            f"{sensors} an expected F1 of {promise.mean[-1]:.3f} {promise.where} "
            f"(95 % interval {promise.low[-1]:.2f} to {promise.high[-1]:.2f}; target {self.target:.3g}"
        )
        if self.every_activity:
            worst = int(np.where(self.weights > 0, promise.f1[-1], np.inf).argmin())
            text += (
                f", {self.every_activity:g} for every activity, of which {self.activities[worst]} has the "
                f"lowest, {promise.f1[-1, worst]:.3f}"
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
    stream: Stream | None = None,
) -> WornSet:
    """Choose the cheapest set whose promise reaches the target, or the one beyond which it rises no more.

    The first patch is chosen by `expected`, the macro F1 (N,) of each patch alone and the bounds of its
    interval. In a `stream`, its F1 must reach the target; else that on clips cut out.
    """
    grown = GrownSet(tests.whole, terms, expected[0], every_activity > 0)
    promises, choose = Promises(tests, terms), ByHalves(every_activity > 0)
    for size in sorted({min(most, terms.max_size) for most in (FIRST_SETS, LARGEST_SET)}):
        order = grown.up_to(size)
        alone, low, high = (float(values[order[0]]) for values in expected)
        cut_out = promises.of(order, choose, (alone, low, high))
        promise = promise_in_stream(stream, order, cut_out) if stream else cut_out
        enough, reached = _enough(tests, terms, target, every_activity, order, promise)
        if reached or (len(order) > fewest(order, terms.required) and promise.mean[-1] <= promise.mean[-2]):
            break
    chosen, further = order[:enough], order[enough:]
    cost = float(terms.cost[list(chosen)].sum())
    with_next = promise.first(enough + 1) if further else None
    return WornSet(
        order=chosen, promise=promise.first(enough), cut_out=cut_out.first(enough),
        activities=tests.activities, target=target, every_activity=every_activity, reached=reached,
        cost=cost, weights=tests.weights, further=further, with_next=with_next, most=float(promise.mean[-1]),
    )  # fmt: skip


def _enough(
    tests: SetTests,
    terms: Terms,
    target: float,
    every_activity: float,
    order: Sequence[int],
    promise: Promise,
) -> tuple[int, bool]:
    """The number of patches that reach the target at the least cost, and whether they do.

    If none do, it is the fewest that promise almost as much as the most.
    """
    sizes = np.arange(fewest(order, terms.required), len(order) + 1)
    mean = promise.mean[sizes - 1]
    lowest = promise.f1[sizes - 1][:, tests.weights > 0].min(axis=1)
    good = np.minimum(mean - target, lowest - every_activity) >= -ROUNDING
    reached = bool(good.any())
    if not reached:
        good = mean >= mean.max() - WORTH
        if every_activity > 0:
            good &= lowest >= lowest[good].max() - WORTH
    return int(sizes[good.argmax()]), reached
