# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 of sets of patches on other clips, from halves of the clips that choose sets for each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain

import numpy as np
import scipy

from ..ranking.expected import UNPROVEN, agreement
from ..ranking.stream import CONFIDENCE, Stream
from ..ranking.utility import ExpectedF1
from ..ranking.weights import known_mean, mean_over
from .constraints import Terms
from .headline import short
from .set_tests import SetTests, Tests

RANDOM_SETS = 8
"""Sets drawn at random, whose mean F1 is the level above which a chosen set gains."""

Choose = Callable[[Tests, Terms, int], Sequence[int]]
"""A function that chooses up to a number of patches, in order, by the tests of a trial."""


@dataclass(frozen=True, eq=False)
class Promise:
    """Expected F1 on other clips, for sets of size 1 to K chosen in one way."""

    f1: np.ndarray  # (K, A)
    mean: np.ndarray  # (K,): macro F1
    low: np.ndarray  # (K,): its interval
    high: np.ndarray
    raw: np.ndarray  # (K, A): F1 on the clips that chose the set
    delivered: np.ndarray  # (H, K): macro F1 of sets that a half chose, on the other half
    known: bool = True  # whether parts of the clips could be compared; else the interval is 0 to 1

    def first(self, count: int) -> Promise:
        """The promise for the first `count` set sizes."""
        by_size = ("f1", "mean", "low", "high", "raw")
        firsts = {name: getattr(self, name)[:count] for name in by_size}
        return replace(self, **firsts, delivered=self.delivered[:, :count])

    def at_most(self, other: Promise) -> Promise:
        """No more than another promise for sets of the same size, nor less than for the first patch."""
        sizes = np.minimum(np.arange(len(self.mean)), len(other.mean) - 1)
        above = np.maximum(self.mean - np.maximum(other.mean[sizes], self.mean[0]), 0)
        f1, low = np.maximum(self.f1 - above[:, None], 0), np.maximum(self.low - above, 0)
        return replace(self, f1=f1, mean=self.mean - above, low=low, high=self.high - above)

    def text(self, caution: str = "") -> str:
        """The whole set's expected F1 in words, with its interval or a `caution` in place of that."""
        text = f"an expected F1 of {short(self.mean[-1])} on other clips"
        if not self.known:
            return f"{text}, a guess: parts of these clips cannot be compared"
        return f"{text} ({caution or f'95 % interval {short(self.low[-1])} to {short(self.high[-1])}'})"


@dataclass(frozen=True, eq=False)
class Promises:
    """Promises for sets chosen under the same terms, all compared with the same random sets."""

    tests: SetTests
    terms: Terms
    _levels: dict[Tests, np.ndarray] = field(default_factory=dict)

    def of(self, order: Sequence[int], choose: Choose, alone: ExpectedF1) -> Promise:
        """Expected F1 on other clips of the first patch of a set, the first two, and so on.

        One half of the clips chooses a set in the same way, the other measures its F1 and that of sets
        drawn at random. The mean gain over those, both ways, is added to the F1 of random sets on all clips:
        more of it because all clips choose better than half of them, less if random sets leave less to gain.
        A patch worn can be ignored, so the promise never falls.

        `alone` is that of the first patch alone.
        """
        tests, size = self.tests, len(order)
        level_of = {part: self.level(part, size) for part in [tests.whole, *chain.from_iterable(tests.pairs)]}
        raw = tests.whole.f1_of_first(order)
        more = _better_chosen(tests)
        ways = [way for pair in tests.pairs for way in (pair, pair[::-1])]
        delivered = [self._delivered(choose(here, self.terms, size), there, size) for here, there in ways]
        gains = [
            (f1 - level_of[there])
            * _left(level_of[tests.whole], level_of[there], tests.weights)[:, None]
            * more
            for f1, (_, there) in zip(delivered, ways, strict=True)
        ]
        shown = np.maximum(np.isfinite(gains).sum(axis=0), 1)  # an activity may have too few clips for halves
        believed = 1.0 if tests.plan.disjoint else UNPROVEN  # folds share the subjects they train on
        f1 = level_of[tests.whole] + believed * np.nansum(gains, axis=0) / shown
        mean = rising(np.clip([alone[0], *mean_over(f1[1:], tests.weights)], 0, 1))
        f1 = np.clip(f1 + (mean - mean_over(f1, tests.weights))[:, None], 0, 1)
        mean_of = partial(known_mean, weights=tests.weights)
        apart = [mean_of(level_of[a]) - mean_of(level_of[b]) for a, b in tests.pairs]
        if gains:
            variance = np.mean(np.square(apart), axis=0) / tests.plan.shrink
            variance = variance + np.var([mean_of(gain) for gain in gains], axis=0) / 2
        else:
            variance = np.ones(size)
        reach = scipy.special.ndtri((1 + CONFIDENCE) / 2) * np.sqrt(variance)
        low, high = np.clip(mean - reach, 0, tests.most_shown), np.clip(mean + reach, 0, 1)
        low[0], high[0] = alone[1:]
        shown_by = np.array([mean_of(one) for one in delivered]).reshape(-1, size)
        return Promise(f1, mean, low, high, raw, shown_by, known=bool(gains))

    def level(self, tests: Tests, size: int) -> np.ndarray:
        """Mean F1 of sets drawn at random, by their size, shape (size, A)."""
        level = self._levels.get(tests, np.empty((0, len(self.tests.weights))))
        if len(self.terms.required) > len(level):  # else larger sets begin as those did
            level = level[:0]
        if len(level) < size:
            sets = random_sets(self.terms, size, self.tests.seed)
            more = tests.f1_of_firsts(sets, range(len(level) + 1, size + 1)).mean(axis=0)
            level = self._levels[tests] = np.concatenate([level, more])
        return level[:size]

    def _delivered(self, order: Sequence[int], there: Tests, size: int) -> np.ndarray:
        """F1 of a set chosen elsewhere, by its size, shape (K, A); a shorter set keeps its last F1."""
        f1 = there.f1_of_first(order)
        return np.concatenate([f1, np.repeat(f1[-1:], size - len(f1), axis=0)])


def rising(by_size: np.ndarray) -> np.ndarray:
    """Values (K,) that never fall, nearest to those given and never below the first.

    A sensor that is worn can be ignored. The running maximum would add the luck of every smaller size.
    """
    if len(by_size) < 2:
        return by_size
    fitted = scipy.optimize.isotonic_regression(by_size[1:]).x
    return np.concatenate([by_size[:1], np.maximum(fitted, by_size[0])])


def _left(level: np.ndarray, level_there: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Share of a gain that is left at another level: F1 moves by p (1 - p) with its logit; at most 1."""
    means = (known_mean(f1, weights) for f1 in (level, level_there))
    whole, there = (mean * (1 - mean) for mean in means)
    return np.minimum(np.maximum(whole, 0) / np.maximum(there, 1e-6), 1.0)


def _better_chosen(tests: SetTests) -> float:
    """Factor by which a choice by all clips gains more than one by half of them.

    The gain of a choice goes with the root of the repeatable share of the variance that it is made by (Lush's
    breeder's equation), and twice the clips make 2r / (1 + r) of a share r (Spearman 1910, Brown 1910).
    Single subjects, whose tests share their training clips, say nothing of it.
    """
    if not tests.plan.disjoint:
        return 1.0
    repeats = agreement([(a.single, b.single) for a, b in tests.pairs])
    return float(np.sqrt(2 / (1 + max(repeats, 0.0))))


def random_sets(terms: Terms, size: int, seed: int) -> list[list[int]]:
    """Orders drawn from the patches allowed, the required ones first."""
    rng = np.random.default_rng([seed, 4])
    sets = []
    for _ in range(RANDOM_SETS):
        order: list[int] = []
        for options in terms.required[:size]:
            if not np.isin(order, options).any():
                order.append(int(rng.choice(options)))
        rest = rng.permutation(np.setdiff1d(np.flatnonzero(terms.allowed), order))
        sets.append([*order, *rest.tolist()][:size])
    return sets


def promise_in_stream(stream: Stream, order: Sequence[int], promise: Promise, alone: ExpectedF1) -> Promise:
    """The promise in a stream of the first patch, the first two, and so on, from that on clips alone.

    `alone` is that of the first patch in the stream.
    """
    sets = [order[: count + 1] for count in range(len(order))]
    by_clip = zip(promise.mean.tolist(), promise.low.tolist(), promise.high.tolist(), strict=True)
    losses = np.array([found.loss for found in stream.losing(sets)])
    found = [stream.expected(worn, ExpectedF1(*of)) for worn, of in zip(sets, by_clip, strict=True)]
    mean, low, high = np.array([alone, *found[1:]]).T
    more = rising(mean) - mean
    low, high = np.clip([low + more, high + more], 0, 1)
    f1 = np.clip(promise.f1 - losses + more[:, None], 0, 1)
    return replace(promise, f1=f1, mean=mean + more, low=low, high=high)
