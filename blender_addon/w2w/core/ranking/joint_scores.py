# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches worn together: class scores of one classifier on a set of patches, for every next patch or pair."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice
from typing import Any, TypeVar

import numpy as np

from .joint_fit import JointFit, Training
from .joint_pairs import Seconds, bytes_of_second, second_patches
from .joint_sums import JointSums

Judged = TypeVar("Judged")

TILE_BYTES = 512 * 2**20
"""Memory for what pairs share of their second patches, held for as many of these as it takes."""

NARROW = 0.75
"""Features worn for each window trained on, up to which sums that trainings share take less time."""

AT_ONCE = 16
"""Pairs judged at once."""

LOOK_FROM = 0.3
"""Share of the windows before which no pair is given up: what is lost for sure grows with its square."""

ROUNDING = 1e-9
"""A pair that may be as good as the best so far by this is not given up."""


class _Race:
    """Which pairs may still be the best one.

    Parameters
    ----------
    judge, limit, price
        As for `JointScores.of_pairs`.
    """

    def __init__(
        self,
        judge: Callable[[np.ndarray], np.ndarray],
        limit: Callable[[np.ndarray], np.ndarray] | None,
        price: np.ndarray,
        best: list[float] | None = None,
    ) -> None:
        self._judge, self._limit, self._price = judge, limit, price
        self._best = [-np.inf] if best is None else best

    def among(self, seconds: slice) -> _Race:
        """The same race, of pairs with these second patches."""
        return _Race(self._judge, self._limit, self._price[:, seconds], self._best)

    def stays(self, scores: np.ndarray, first: int, seconds: np.ndarray) -> np.ndarray:
        """Of each pair, whether it may be the best by scores of the first windows."""
        if self._limit is None:
            return np.ones(len(seconds), dtype=bool)
        return self._limit(scores) / self._price[first, seconds] >= self._best[0] - ROUNDING

    def judged(self, scores: np.ndarray, first: int, seconds: np.ndarray) -> np.ndarray:
        """The values of pairs that got through."""
        values = self._judge(scores)
        # Threads may overwrite each other's best with a lesser one: then fewer are given up, never too many.
        self._best[0] = max(self._best[0], float((values / self._price[first, seconds]).max()))
        return values


class JointScores:
    """Ridge discriminant analysis on several patches' features side by side.

    It is the classifier of `Ridge` with the ridge multiplied by the number of patches, so that the
    kernel of a set is the mean of its patches' kernels and a wide set is held back no less than a
    single patch. How a training is solved says `JointFit`.

    Parameters
    ----------
    features : ndarray, shape (N, W, D), float32
        Of each patch, about their means over windows.
    labels : ndarray of int, shape (W,)
        Activity of each window, 0 to A - 1.
    trainings : sequence of Training
    ridge : float
        In units of a feature's variance within classes.
    workers : int
        Threads; whoever calls keeps BLAS to one in each.

    Attributes
    ----------
    n_patches : int
    windows : ndarray of int, shape (V,)
        The windows tested, training by training, as scores are.
    """

    def __init__(
        self,
        features: np.ndarray,
        labels: np.ndarray,
        trainings: Sequence[Training],
        ridge: float,
        workers: int = 2,
    ) -> None:
        self.n_patches = len(features)
        self._workers = workers
        n_activities = int(labels.max()) + 1
        self._fits = [JointFit(features, labels, training, n_activities, ridge) for training in trainings]
        self._sums = JointSums(features, labels, self._fits)
        self.windows = np.concatenate([training.tested for training in trainings])

    def of_added(
        self, worn: Sequence[int], candidates: Iterable[int], judge: Callable[[np.ndarray], Judged]
    ) -> list[Judged]:
        """What is judged of the patches worn and one more, for each candidate.

        Parameters
        ----------
        worn : sequence of int
        candidates : iterable of int
        judge : callable
            Given scores (V, A), float32: logarithms of the classes' probabilities, but for a term that
            all classes share. Called from several threads.
        """
        add = self._added_by_sums(worn) if self._is_narrow(len(worn)) else self._added_by_fits(worn)
        return list(self._parallel(lambda candidate: judge(add(candidate)), candidates))

    def _is_narrow(self, worn: int) -> bool:
        """Whether windows are many for so many patches worn, in every training."""
        return not any(fit.few or worn * fit.shape[2] > NARROW * fit.shape[0] for fit in self._fits)

    def _added_by_sums(self, worn: Sequence[int]) -> Callable[[int], np.ndarray]:
        return partial(self._sums.add, self._sums.wear(worn))

    def _added_by_fits(self, worn: Sequence[int]) -> Callable[[int], np.ndarray]:
        bases = list(self._parallel(lambda fit: fit.wear(worn), self._fits))

        def add(candidate: int) -> np.ndarray:
            scores = [fit.add(base, candidate) for fit, base in zip(self._fits, bases, strict=True)]
            return np.concatenate(scores)

        return add

    def of_pairs(
        self,
        candidates: Sequence[int],
        wanted: np.ndarray,
        judge: Callable[[np.ndarray], np.ndarray],
        limit: Callable[[np.ndarray], np.ndarray] | None = None,
        price: np.ndarray | None = None,
    ) -> np.ndarray:
        """What is judged of every pair of candidates, or of those that may be the best.

        What does not depend on the first patch is prepared for many second ones, what does not depend
        on the second once for each first.

        Parameters
        ----------
        candidates : sequence of int, length C
        wanted : ndarray of bool, shape (C, C)
            The pairs to judge; those above the diagonal count.
        judge : callable
            Given scores (P, V, A) of some pairs as `of_added` has them, returns P values.
        limit : callable, optional
            Given scores (P, v, A) of the first v windows, returns what the values will not exceed. A pair
            is then given up as soon as it cannot be the best one any more.
        price : ndarray, shape (C, C), optional
            The best pair has the largest value divided by its price; 1 for every pair by default.

        Returns
        -------
        ndarray, shape (C, C)
            Minus infinity for pairs not wanted or given up.
        """
        values = np.full(wanted.shape, -np.inf)
        wanted = np.triu(wanted, 1)
        race = _Race(judge, limit, np.ones(wanted.shape) if price is None else price)
        size = max(1, TILE_BYTES // sum(map(bytes_of_second, self._fits)))
        for start in range(0, len(candidates), size):
            tile = candidates[start : start + size]
            seconds = [second_patches(fit, len(tile)) for fit in self._fits]
            self._each(lambda number, s=seconds, t=tile: [one.put(number, t[number]) for one in s], len(tile))
            here = slice(start, start + len(tile))
            row = partial(self._row, candidates, seconds, wanted[:, here], race.among(here), values[:, here])
            self._each(row, here.stop)
        return values

    def _row(
        self,
        candidates: Sequence[int],
        seconds: Sequence[Seconds],
        wanted: np.ndarray,
        race: _Race,
        values: np.ndarray,
        number: int,
    ) -> None:
        """Judge one candidate with all that are wanted of the second ones prepared."""
        others = np.flatnonzero(wanted[number])
        if not len(others):
            return
        firsts = [one.first(candidates[number]) for one in seconds]
        for start in range(0, len(others), AT_ONCE):
            left, scores = others[start : start + AT_ONCE], None
            for one, first in zip(seconds, firsts, strict=True):
                new = one.scores(first, left)
                scores = new if scores is None else np.concatenate([scores, new], axis=1)
                if LOOK_FROM * len(self.windows) <= scores.shape[1] < len(self.windows):
                    stays = race.stays(scores, number, left)
                    left, scores = left[stays], scores[stays]
                if not len(left):
                    break
            else:
                values[number, left] = race.judged(scores, number, left)

    def each_first(self, order: Sequence[int]) -> list[np.ndarray]:
        """Scores (V, A) by the first patch, by the first two, and so on."""
        return next(self.each_first_of([order]))

    def each_first_of(
        self, orders: Sequence[Sequence[int]], sizes: Sequence[int] | None = None
    ) -> Iterator[list[np.ndarray]]:
        """As `each_first`, of one order after another; by so many of their first patches only, if told.

        The numbers ascend; those that an order has not are passed over.
        """

        def of(order_and_fit: tuple[Sequence[int], JointFit]) -> list[np.ndarray]:
            order, fit = order_and_fit
            some = range(1, len(order) + 1) if sizes is None else [n for n in sizes if n <= len(order)]
            sums = zip(some, fit.sums_of_kernels(order, some), strict=True)
            return [fit.scores(kernels, count) for count, kernels in sums]

        found = self._parallel(of, [(order, fit) for order in orders for fit in self._fits])
        for _ in orders:
            of_fits = islice(found, len(self._fits))
            yield [np.concatenate(of_size) for of_size in zip(*of_fits, strict=True)]

    def _parallel(self, work: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        with ThreadPoolExecutor(self._workers) as pool:
            yield from pool.map(work, items)

    def _each(self, work: Callable[[int], Any], count: int) -> None:
        for _ in self._parallel(work, range(count)):
            pass
