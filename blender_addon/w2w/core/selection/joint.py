# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen by the classifier that will be worn, and what such a set would reach on other clips."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..ranking.costs import EQUAL, as_shown
from ..ranking.stream import Stream
from ..ranking.utility import ExpectedF1
from ..ranking.weights import mean_over
from ..wording import InShort
from .constraints import Terms, fewest
from .headline import short
from .promise import Promise, Promises, promise_in_stream
from .set_tests import SetTests, Tests

LARGEST_SET = 6
"""Sensors up to which sets are grown."""

FIRST_SETS = 3
"""Sensors up to which sets are grown at first; then one more as long as the last was worth it."""

WORTH = 0.02
"""Expected F1 that each further sensor must add to be recommended."""

SHORTLIST = 0.25
"""Share of the candidates that stay candidates once they have been tried with the patches worn."""

LEAST_LISTED = 32
"""Minimum shortlist. On 826 clips the best next patch was missing 1 time in 20, at a cost of .0002 in AUC."""

ALIKE = 0.005
"""Area under the ROC curve by which further patches do alike: half of the last digit shown."""

OF_HALVES = 128
"""Candidates of a half: the first patches, which were sampled to lie far apart."""


class GrownSet:
    """A set that grows by the patch with which the classifier separates activities best.

    Of patches that do alike it takes the cheapest, then the least rare: a hair's breadth does not decide.
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
        while len(order) < min(size, terms.max_size):
            missing = [options for options in terms.required if not np.isin(order, options).any()]
            tried = (missing[0] if missing else np.setdiff1d(self.candidates, order))[: self._among]
            if not len(tried):
                break
            value = self._tests.added(order, tried, self._worst) if order else self._first[tried]
            gain = (value - self._area) / terms.price[tried]
            best = self._best(tried, gain, ALIKE if order else EQUAL)
            if order:
                self._area = float(value[best])
                if not missing and not self._worst:
                    most = max(int(SHORTLIST * len(tried)), LEAST_LISTED)
                    self.candidates = np.sort(tried[np.argsort(-gain, kind="stable")[:most]])
            order.append(int(tried[best]))
        return tuple(order[:size])

    def _best(self, tried: np.ndarray, gain: np.ndarray, margin: float) -> int:
        """Number among the patches tried of that to take, by what each gains for its price."""
        alike = np.flatnonzero(gain.max() - gain <= margin)
        patches, terms = tried[alike], self._terms
        rarity = np.zeros(len(alike)) if terms.rarity is None else terms.rarity[patches]
        return int(alike[np.lexsort((-gain[alike], rarity, terms.price[patches]))[0]])


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


@dataclass(frozen=True, eq=False, repr=False)
class WornSet(InShort):
    """A set of patches chosen to be worn together."""

    order: tuple[int, ...]  # the patches recommended, in order of choice
    promise: Promise  # for the first, the first two, and so on
    activities: tuple[str, ...]
    target: float  # expected macro F1 to reach
    every_activity: float  # least expected F1 of any activity; 0 for none
    reached: bool
    price: float
    weights: np.ndarray  # (A,): what each activity counts
    further: tuple[int, ...]  # patches that were tried after these, in order of choice
    with_next: Promise | None  # for these patches and the first of `further`, if that is shown to add any F1
    most: float  # expected F1 of the largest set tried
    caution: str  # in place of an interval; "" if there are clips enough for one

    @property
    def raw_mean(self) -> np.ndarray:
        """Macro F1 of the first patch, the first two, and so on, on the clips that chose them."""
        return mean_over(self.promise.raw, self.weights)

    def in_short(self) -> str:
        """What the set would reach, in words."""
        return self.sentence()

    def sentence(self) -> str:
        """Say in words what the set would reach on other clips."""
        promise, count = self.promise, len(self.order)
        sensors = "1 sensor reaches" if count == 1 else f"{count} sensors worn together reach"
        text = f"{sensors} {promise.text(self.caution)}; the target is {short(self.target)}"
        if self.every_activity:
            worst = int(np.where(self.weights > 0, promise.f1[-1], np.inf).argmin())
            text += (
                f", and {short(self.every_activity)} for every activity, of which {self.activities[worst]} "
                f"has the lowest, {short(promise.f1[-1, worst])}"
            )
        if self.reached:
            return text
        if self.further:
            tried = count + len(self.further)
            return f"{text}; no set of up to {tried} sensors reaches more than {short(self.most)}"
        return f"{text}; no more sensors are allowed"


class _Given(NamedTuple):
    """What a search goes by, besides tests and terms."""

    expected: ExpectedF1
    worst: bool
    stream: Stream | None
    first: np.ndarray


class _Search:
    """Sets that grow under some terms, and their promises.

    Wishes can only take away. But a search takes one way among very many, and halves of the clips judge it
    with noise: so no set promises more than the set of its size that was found without wishes.
    """

    def __init__(self, tests: SetTests, terms: Terms, given: _Given) -> None:
        self._grown, self._given = GrownSet(tests.whole, terms, given.first, given.worst), given
        self._promises, self._choose = Promises(tests, terms), ByHalves(given.worst)
        self._free = terms.unwished and _search(tests, terms.unwished, given)
        self._found: dict[int, tuple[tuple[int, ...], Promise]] = {}

    def up_to(self, size: int) -> tuple[tuple[int, ...], Promise]:
        """The patches in order of choice, up to a size, and what they promise."""
        if size not in self._found:
            self._found[size] = self._up_to(size)
        return self._found[size]

    def _up_to(self, size: int) -> tuple[tuple[int, ...], Promise]:
        order = self._grown.up_to(size)
        alone = self._given.expected.at(order[0])
        if stream := self._given.stream:
            lost = mean_over(stream.lost, self._promises.tests.weights)
            promise = self._promises.of(order, self._choose, ExpectedF1(*(value + lost for value in alone)))
            promise = promise_in_stream(stream, order, promise, alone)
        else:
            promise = self._promises.of(order, self._choose, alone)
        return order, promise.at_most(self._free.up_to(len(order))[1]) if self._free else promise


def _search(tests: SetTests, terms: Terms, given: _Given) -> _Search:
    """A search; one without wishes is kept with its tests, as the next wishes are held against it, too."""
    if terms.unwished:
        return _Search(tests, terms, given)
    arrays = given.expected.mean, given.first, terms.allowed, terms.price, *terms.required
    key = *(array.tobytes() for array in arrays), terms.max_size, given.worst, given.stream
    if key not in tests.searches:
        tests.searches[key] = _Search(tests, terms, given)
    return tests.searches[key]


def grow_unwished(tests: SetTests) -> None:
    """Grow the sets without wishes that are known to the largest: wishes are held against them."""
    for search in tests.searches.values():
        search.up_to(LARGEST_SET)


def choose_together(
    tests: SetTests,
    expected: ExpectedF1,
    terms: Terms,
    target: float = 0.9,
    every_activity: float = 0.0,
    stream: Stream | None = None,
    first: np.ndarray | None = None,
    caution: str = "",
) -> WornSet:
    """Choose the smallest set that reaches the target, or the one beyond which no sensor is worth it.

    `expected` is that of each patch (N,) alone; the first patch is that of the highest, or of the highest of
    `first` (N,). In a `stream` all of it is F1 there. A `caution` is said in place of an interval.
    """
    best_alone = expected.mean if first is None else first
    search = _search(tests, terms, _Given(expected, every_activity > 0, stream, best_alone))
    for size in sorted({min(most, terms.max_size) for most in range(FIRST_SETS, LARGEST_SET + 1)}):
        order, promise = search.up_to(size)
        lowest = promise.f1[:, tests.weights > 0].min(axis=1)
        f1, wanted = np.array([promise.mean, lowest]), np.array([[target], [every_activity]])
        lacks = (as_shown(wanted) - as_shown(f1)).max(axis=0)
        enough = _enough(fewest(order, terms.required), lacks, promise.delivered)
        reached = bool(lacks[enough - 1] <= 0)
        if reached or enough < len(order):
            break
    chosen, further = order[:enough], order[enough:]
    rises = further and short(promise.mean[enough]) != short(promise.mean[enough - 1])
    return WornSet(
        order=chosen, promise=promise.first(enough),
        activities=tests.activities, target=target, every_activity=every_activity, reached=reached,
        price=float(terms.price[list(chosen)].sum()), weights=tests.weights, further=further,
        with_next=promise.first(enough + 1) if rises else None, most=float(promise.mean[-1]),
        caution=caution,
    )  # fmt: skip


def _enough(fewest_sensors: int, lacks: np.ndarray, delivered: np.ndarray) -> int:
    """The number of sensors to recommend, by what each number lacks of the target and halves delivered.

    More are worth it if each adds `WORTH`, as expected and by halves (H, K), until the target is reached.
    """
    enough = fewest_sensors
    for size in range(enough + 1, len(lacks) + 1):
        gain = lacks[enough - 1] - lacks[size - 1]
        came = np.median(delivered[:, size - 1] - delivered[:, enough - 1]) if len(delivered) else 0.0
        worth_it = min(gain, as_shown(came)) + 1e-9 >= WORTH * (size - enough)  # but for rounding
        if lacks[enough - 1] > 0 and worth_it:
            enough = size
    return enough
