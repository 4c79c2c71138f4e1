# SPDX-License-Identifier: GPL-3.0-or-later
"""One training of a classifier on several patches' features side by side, whatever the patches.

Where windows are many, a patch enters by its features, and what patches worn explain is taken out of the
windows first (`_Worn`): a candidate then costs hardly more than it would alone, by the inverse of a matrix in
blocks. Where they are few, it enters by its kernel between windows (Saunders, Gammerman and Vovk 1998).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from ..blas import add_square, multiply, multiply_lower, solve_positive
from .class_sums import averaging
from .classifiers.discriminant import deviation, with_ridge

FEW = 1.2
"""Windows for each feature up to which kernels of windows are solved where one more patch is worn."""


class Training(NamedTuple):
    """Windows trained on, and windows tested on what was trained."""

    trained: np.ndarray
    tested: np.ndarray


class Rows(NamedTuple):
    """A patch's features in units of their deviation within classes.

    `within` (n, D) are the windows trained on about their class means, `means` (A, D), `tested` (v, D).
    """

    within: np.ndarray
    means: np.ndarray
    tested: np.ndarray


class Kernels(NamedTuple):
    """Products of the rows of patches, summed over patches: of each two kinds of `Rows`.

    Of `within_within` (n, n) the upper triangle; `means_within` (A, n), `tested_within` (v, n),
    `tested_means` (v, A), and of the means (A,) with themselves.
    """

    within_within: np.ndarray
    means_within: np.ndarray
    tested_within: np.ndarray
    tested_means: np.ndarray
    means_means: np.ndarray

    def plus(self, other: Kernels) -> Kernels:
        """Of both."""
        return Kernels(*map(np.add, self, other))

    def add(self, rows: Rows) -> None:
        """Take in one more patch, or several side by side."""
        within, means, tested = rows
        add_square(self.within_within, within.T)
        self.means_within[...] += multiply(means, within.T)
        self.tested_within[...] += multiply(tested, within.T)
        self.tested_means[...] += multiply(tested, means.T)
        self.means_means[...] += np.einsum("ad,ad->a", means, means)


class _Worn(NamedTuple):
    """What patches worn explain.

    Attributes
    ----------
    left : ndarray, shape (n, n), or None
        Lower triangle; takes what they explain out of the windows trained on; None where nothing is worn.
    means : ndarray, shape (A, n)
        What they say of the class means, by window.
    tested : ndarray, shape (v, n)
        What they share between windows tested and trained on.
    scores : ndarray, shape (v, A)
    norms : ndarray, shape (A,)
        Squared lengths of the class means.
    count : int
    """

    left: np.ndarray | None
    means: np.ndarray
    tested: np.ndarray
    scores: np.ndarray
    norms: np.ndarray
    count: int


class JointFit:
    """One training.

    Parameters
    ----------
    features, labels, ridge
        As for `JointScores`.
    training : Training
    n_activities : int
    """

    def __init__(
        self, features: np.ndarray, labels: np.ndarray, training: Training, n_activities: int, ridge: float
    ) -> None:
        self._features, self.training = features, training
        self.n_activities = n_activities
        self._labels = labels[training.trained]
        self._counts = np.bincount(self._labels, minlength=n_activities).astype(np.float32)
        self._average = averaging(self._labels, n_activities)
        self.ridge = np.float32(ridge * len(self._labels))
        self._scales: dict[int, np.ndarray] = {}
        self.few = len(self._labels) <= FEW * features.shape[2]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Windows trained on, windows tested, features of a patch."""
        return len(self._labels), len(self.training.tested), self._features.shape[2]

    def rows(self, patch: int) -> Rows:
        """The rows of a patch."""
        inputs = self._features[patch]
        seen = inputs[self.training.trained]
        means = self._average @ seen
        within = seen - means[self._labels]
        scale = self._scales.get(patch)
        if scale is None:
            scale = self._scales[patch] = _scale(seen, within)
        within /= scale
        return Rows(within, means / scale, inputs[self.training.tested] / scale)

    def kernels(self, patches: Sequence[int]) -> Kernels:
        """The kernels of patches, summed."""
        return next(self.sums_of_kernels(patches, [len(patches)]))

    def sums_of_kernels(self, patches: Sequence[int], sizes: Iterable[int]) -> Iterator[Kernels]:
        """The kernels of so many of the first patches, for ascending numbers: one and the same, added to."""
        trained, tested, classes = len(self._labels), len(self.training.tested), len(self._counts)
        shapes = ((trained, trained), (classes, trained), (tested, trained), (tested, classes), (classes,))
        summed = Kernels(*(np.zeros(shape, dtype=np.float32) for shape in shapes))
        for before, count in pairwise([0, *sizes]):
            rows = zip(*map(self.rows, patches[before:count]), strict=True)
            summed.add(Rows(*(np.concatenate(of_patches, axis=1) for of_patches in rows)))
            yield summed

    def scores(self, kernels: Kernels, count: int) -> np.ndarray:
        """Scores (v, A) by `count` patches."""
        ridge = self.ridge * count
        return self.solve(kernels, with_ridge(kernels.within_within.copy(), ridge), ridge)

    def solve(self, kernels: Kernels, matrix: np.ndarray, ridge: np.float32) -> np.ndarray:
        """Scores (v, A) by summed kernels; those of the windows with the ridge are overwritten."""
        means = solve_positive(matrix, kernels.means_within)
        products = kernels.tested_means - kernels.tested_within @ means.T
        norms = kernels.means_means - np.einsum("an,an->a", kernels.means_within, means)
        return self.offset(products / ridge, norms / ridge)

    def wear(self, patches: Sequence[int]) -> _Worn | tuple[Kernels | None, int]:
        """What patches say where one more will be worn."""
        kernels = self.kernels(patches) if patches else None
        if self.few:
            return kernels, len(patches)
        if kernels is not None:
            return self._explain(kernels, len(patches))
        trained, tested, classes = len(self._labels), len(self.training.tested), len(self._counts)
        nothing = ((classes, trained), (tested, trained), (tested, classes), (classes,))
        return _Worn(None, *(np.zeros(shape, np.float32) for shape in nothing), 0)

    def add(self, worn: _Worn | tuple[Kernels | None, int], patch: int) -> np.ndarray:
        """Scores (v, A) by the patches worn and one more."""
        if not isinstance(worn, _Worn):
            kernels, count = worn
            own = self.kernels([patch])
            return self.scores(own if kernels is None else kernels.plus(own), count + 1)
        within, means, tested = self.rows(patch)
        new = within if worn.left is None else multiply_lower(worn.left, within)
        gram = self.gram(new, worn.count + 1)
        means = means - worn.means @ within
        slopes = solve_positive(gram, means)
        scores = worn.scores + tested @ slopes.T
        if worn.left is not None:
            scores -= worn.tested @ (within @ slopes.T)
        return self.offset(scores, worn.norms + np.einsum("ad,ad->a", means, slopes))

    def _explain(self, kernels: Kernels, count: int) -> _Worn:
        ridge = self.ridge * (count + 1)
        matrix = with_ridge(kernels.within_within.copy(), ridge)
        lower = cholesky(matrix.T, lower=True, overwrite_a=True, check_finite=False)
        identity = np.eye(len(lower), dtype=np.float32, order="F")
        inverse = solve_triangular(lower, identity, lower=True, overwrite_b=True, check_finite=False)
        means, tested = kernels.means_within @ inverse.T, kernels.tested_within @ inverse.T
        return _Worn(
            left=np.sqrt(ridge) * inverse,
            means=means @ inverse,
            tested=tested @ inverse,
            scores=(kernels.tested_means - tested @ means.T) / ridge,
            norms=(kernels.means_means - np.einsum("an,an->a", means, means)) / ridge,
            count=count,
        )

    def gram(self, rows: np.ndarray, count: int) -> np.ndarray:
        """Upper triangle of the Gram matrix of rows, with the ridge of so many patches."""
        gram = with_ridge(np.zeros((rows.shape[1],) * 2, dtype=np.float32), self.ridge * count)
        add_square(gram, rows)
        return gram

    def offset(self, products: np.ndarray, norms: np.ndarray) -> np.ndarray:
        """Scores (v, A) from products with the class means and these' squared lengths (A,)."""
        offset = np.where(self._counts > 0, norms / 2, np.inf).astype(np.float32)
        return (products - offset) * np.float32(len(self._labels))


def _scale(seen: np.ndarray, within: np.ndarray) -> np.ndarray:
    """Deviation of each feature within classes; infinite for one that never varies."""
    squares = (np.einsum("nd,nd->d", rows, rows) for rows in (within, seen))
    return deviation(*(square / len(seen) for square in squares)).astype(np.float32)
