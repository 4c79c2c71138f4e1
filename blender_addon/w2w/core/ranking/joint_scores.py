# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches worn together: class scores of one classifier on a set of patches, for every next patch."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice
from typing import Any, TypeVar

import numpy as np

from .joint_fit import JointFit, Training
from .joint_sums import JointSums

Judged = TypeVar("Judged")

NARROW = 0.75
"""Features worn for each window trained on, up to which sums that trainings share take less time."""


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
