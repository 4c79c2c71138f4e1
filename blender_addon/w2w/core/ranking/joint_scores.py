# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches worn together: class scores of one classifier on a set of patches, for every next patch at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from ..blas import solve_positive
from .classifiers.ridge import LEAST_WITHIN, NEVER_VARIES


class Training(NamedTuple):
    """Windows trained on, and windows tested on what was trained."""

    trained: np.ndarray
    tested: np.ndarray


class JointScores:
    """Ridge discriminant analysis on several patches' features side by side.

    It is the classifier of `Ridge` with the ridge multiplied by the number of patches, so that the
    kernel of a set is the mean of its patches' kernels and a wide set is held back no less than a
    single patch. The patches worn enter by their kernels between windows (Saunders, Gammerman and
    Vovk 1998). What they explain is taken out of the windows once a training (`_Worn`); each
    candidate then costs hardly more than it would alone, by the inverse of a matrix in blocks.

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
        self._features = features
        self.n_patches = len(features)
        self._workers = workers
        self._fits = [_Fit(labels, training, int(labels.max()) + 1, ridge) for training in trainings]
        self.windows = np.concatenate([training.tested for training in trainings])

    def each_added(self, worn: Sequence[int], candidates: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
        """Scores by the patches worn and one more, for each candidate in turn.

        Yields
        ------
        candidate : int
        scores : ndarray, shape (V, A), float32
            Logarithms of the classes' probabilities, but for a term that all classes share.
        """
        bases = [fit.wear([self._features[patch] for patch in worn]) for fit in self._fits]

        def scores(candidate: int) -> np.ndarray:
            inputs = self._features[candidate]
            return np.concatenate(
                [fit.add(base, inputs) for fit, base in zip(self._fits, bases, strict=True)]
            )

        yield from zip(candidates, self._parallel(scores, candidates), strict=True)

    def each_first(self, order: Sequence[int]) -> list[np.ndarray]:
        """Scores (V, A) by the first patch, by the first two, and so on."""

        def of_fit(fit: _Fit) -> list[np.ndarray]:
            sums = fit.sums_of_kernels(self._features[patch] for patch in order)
            return [fit.scores(kernels, count) for count, kernels in enumerate(sums, start=1)]

        return [np.concatenate(of_size) for of_size in zip(*self._parallel(of_fit, self._fits), strict=True)]

    def _parallel(self, work: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        with ThreadPoolExecutor(self._workers) as pool:
            yield from pool.map(work, items)


class _Rows(NamedTuple):
    """A patch's features in units of their deviation within classes, in one training.

    `within` (n, D) are the windows trained on about their class means, `means` (A, D), `tested` (v, D).
    """

    within: np.ndarray
    means: np.ndarray
    tested: np.ndarray


class _Kernels(NamedTuple):
    """Products of the rows of patches, summed over patches: of each two kinds of `_Rows`."""

    within_within: np.ndarray
    within_means: np.ndarray
    means_means: np.ndarray
    tested_within: np.ndarray
    tested_means: np.ndarray


class _Worn(NamedTuple):
    """What patches worn explain in one training.

    Attributes
    ----------
    left : ndarray, shape (n, n), or None
        Takes what they explain out of the windows trained on; None where nothing is worn.
    means : ndarray, shape (n, A)
        What they say of the class means, by window.
    tested : ndarray, shape (v, n)
        What they share between windows tested and trained on.
    scores : ndarray, shape (v, A)
    norms : ndarray, shape (A,)
        Squared lengths of the class means.
    ridge : float
    """

    left: np.ndarray | None
    means: np.ndarray
    tested: np.ndarray
    scores: np.ndarray
    norms: np.ndarray
    ridge: float


class _Fit:
    """One training: its windows, whatever the patches."""

    def __init__(self, labels: np.ndarray, training: Training, n_activities: int, ridge: float) -> None:
        self.training = training
        self.member = np.eye(n_activities, dtype=np.float32)[labels[training.trained]]
        self.counts = self.member.sum(axis=0)
        self.average = np.ascontiguousarray((self.member / np.maximum(self.counts, 1)).T)
        self.ridge = np.float32(ridge * len(self.member))

    def rows(self, inputs: np.ndarray) -> _Rows:
        """The rows of a patch, from its features (W, D)."""
        seen = inputs[self.training.trained]
        means = self.average @ seen
        within = seen - self.member @ means
        variance = np.einsum("nd,nd->d", within, within) / len(seen)
        least = LEAST_WITHIN * np.einsum("nd,nd->d", seen, seen) / len(seen)
        variance = np.maximum(variance, least)
        scale = np.sqrt(np.where(variance > NEVER_VARIES, variance, np.inf)).astype(np.float32)
        return _Rows(within / scale, means / scale, inputs[self.training.tested] / scale)

    def kernels(self, inputs: np.ndarray) -> _Kernels:
        """The kernels of a patch."""
        within, means, tested = self.rows(inputs)
        return _Kernels(
            within @ within.T, within @ means.T, means @ means.T, tested @ within.T, tested @ means.T
        )

    def sums_of_kernels(self, features: Iterable[np.ndarray]) -> Iterator[_Kernels]:
        """The kernels of the first patch, of the first two, and so on."""
        return accumulate(map(self.kernels, features), lambda total, own: _Kernels(*map(np.add, total, own)))

    def scores(self, kernels: _Kernels, count: int) -> np.ndarray:
        """Scores (v, A) by `count` patches."""
        worn = self._explain(kernels, self.ridge * count)
        return self._scores(worn.scores, worn.norms)

    def wear(self, features: Sequence[np.ndarray]) -> _Worn:
        """What patches of features (W, D) explain where one more will be worn."""
        ridge = self.ridge * (len(features) + 1)
        if features:
            *_, kernels = self.sums_of_kernels(features)
            return self._explain(kernels, ridge)
        trained, tested, classes = len(self.member), len(self.training.tested), len(self.counts)
        nothing = ((trained, classes), (tested, trained), (tested, classes), (classes,))
        return _Worn(None, *(np.zeros(shape, np.float32) for shape in nothing), ridge)

    def _explain(self, kernels: _Kernels, ridge: float) -> _Worn:
        matrix = kernels.within_within.copy()
        matrix.flat[:: len(matrix) + 1] += ridge
        lower = cholesky(matrix, lower=True, overwrite_a=True, check_finite=False)
        inverse = solve_triangular(
            lower, np.eye(len(lower), dtype=np.float32), lower=True, check_finite=False
        )
        means, tested = inverse @ kernels.within_means, kernels.tested_within @ inverse.T
        return _Worn(
            left=np.sqrt(ridge) * inverse,
            means=inverse.T @ means,
            tested=tested @ inverse,
            scores=(kernels.tested_means - tested @ means) / ridge,
            norms=(np.diag(kernels.means_means) - np.einsum("na,na->a", means, means)) / ridge,
            ridge=ridge,
        )

    def add(self, worn: _Worn, inputs: np.ndarray) -> np.ndarray:
        """Scores (v, A) by the patches worn and one more, of features (W, D)."""
        within, means, tested = self.rows(inputs)
        new = within if worn.left is None else worn.left @ within
        gram = new.T @ new
        gram.flat[:: len(gram) + 1] += worn.ridge
        means = means - worn.means.T @ within
        slopes = solve_positive(gram, means)
        scores = worn.scores + tested @ slopes.T - worn.tested @ (within @ slopes.T)
        return self._scores(scores, worn.norms + np.einsum("ad,ad->a", means, slopes))

    def _scores(self, products: np.ndarray, norms: np.ndarray) -> np.ndarray:
        offset = np.where(self.counts > 0, norms / 2, np.inf).astype(np.float32)
        return (products - offset) * np.float32(len(self.member))
