# SPDX-License-Identifier: GPL-3.0-or-later
"""Pairs of patches in one training: what is the second patch's alone is prepared for many, then each first.

As in `joint_fit`, by the patches' features where windows are many, by kernels of windows where they are few.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from ..blas import add_square, solve_positive
from .classifiers.discriminant import with_ridge
from .joint_fit import JointFit, Kernels

FEW = 1.6
"""Windows for each feature up to which kernels are solved: of pairs they are made once for many."""


class First(NamedTuple):
    """The first patch of pairs: its rows `within` (n, D), `means` (A, D) and `tested` (v, D) in units in
    which its features do not correlate, and what it says alone, `scores` (v, A) and `norms` (A,)."""

    within: np.ndarray
    means: np.ndarray
    tested: np.ndarray
    scores: np.ndarray
    norms: np.ndarray


class PairsByFeatures:
    """Second patches by their features: rows and Gram matrices with the ridge, a patch after another.

    Parameters
    ----------
    fit : JointFit
    count : int
        How many patches there is room for.
    """

    def __init__(self, fit: JointFit, count: int) -> None:
        n, tested, width = fit.shape
        self._fit = fit
        self._within = np.empty((count, width, n), dtype=np.float32)
        self._gram = np.empty((count, width, width), dtype=np.float32)
        self._means = np.empty((count, fit.n_activities, width), dtype=np.float32)
        self._tested = np.empty((count, tested, width), dtype=np.float32)

    def put(self, number: int, patch: int) -> None:
        """Prepare a second patch."""
        within, self._means[number], self._tested[number] = self._fit.rows(patch)
        self._within[number] = within.T
        self._gram[number] = self._fit.gram(within, 2)

    def first(self, patch: int) -> First:
        """What the first patch says, whatever the second."""
        rows = self._fit.rows(patch)
        upper = cholesky(self._fit.gram(rows.within, 2), overwrite_a=True, check_finite=False)
        within, means, tested = (
            np.ascontiguousarray(solve_triangular(upper, kind.T, trans="T", check_finite=False).T)
            for kind in rows
        )
        return First(within, means, tested, tested @ means.T, np.einsum("ad,ad->a", means, means))

    def scores(self, first: First, numbers: np.ndarray) -> np.ndarray:
        """Scores (P, v, A) by a first patch and each of P of the second ones."""
        chosen = _as_they_lie(numbers)
        within, gram = self._within[chosen], self._gram[chosen].copy()
        count, width, n = within.shape
        shared = (within.reshape(-1, n) @ first.within).reshape(count, width, width)
        said = (shared.reshape(-1, width) @ first.means.T).reshape(count, width, -1)
        means = self._means[chosen] - said.swapaxes(1, 2)
        slopes = np.empty(means.shape, dtype=np.float32)
        for number in range(count):
            add_square(gram[number], shared[number].T, -1.0)
            slopes[number] = solve_positive(gram[number], means[number])
        scores = first.scores + self._tested[chosen] @ slopes.swapaxes(1, 2)
        scores -= (slopes @ shared @ first.tested.T).swapaxes(1, 2)
        return self._fit.offset(scores, first.norms + (means * slopes).sum(axis=2))


class PairsByWindows:
    """Second patches by their kernels between windows, with the ridge.

    Parameters
    ----------
    fit : JointFit
    count : int
        How many patches there is room for.
    """

    def __init__(self, fit: JointFit, count: int) -> None:
        self._fit = fit
        self._kernels: list[Kernels | None] = [None] * count

    def put(self, number: int, patch: int) -> None:
        """Prepare a second patch."""
        kernels = self._fit.kernels([patch])
        with_ridge(kernels.within_within, 2 * self._fit.ridge)
        self._kernels[number] = kernels

    def first(self, patch: int) -> Kernels:
        """What the first patch says, whatever the second."""
        return self._fit.kernels([patch])

    def scores(self, first: Kernels, numbers: np.ndarray) -> np.ndarray:
        """Scores (P, v, A) by a first patch and each of P of the second ones."""
        both = [first.plus(self._kernels[number]) for number in numbers]
        ridge = 2 * self._fit.ridge
        return np.stack([self._fit.solve(kernels, kernels.within_within, ridge) for kernels in both])


Seconds = PairsByFeatures | PairsByWindows
"""Second patches of pairs, prepared."""


def second_patches(fit: JointFit, count: int) -> Seconds:
    """Room for so many second patches, in the way that takes less time."""
    return PairsByWindows(fit, count) if _few(fit) else PairsByFeatures(fit, count)


def bytes_of_second(fit: JointFit) -> int:
    """Memory that a second patch takes."""
    n, tested, width = fit.shape
    values = (n + tested) * (n + fit.n_activities) if _few(fit) else (n + tested + width) * width
    return values * np.dtype(np.float32).itemsize


def _as_they_lie(numbers: np.ndarray) -> slice | np.ndarray:
    """Ascending numbers as a slice where none is left out: nothing is copied then."""
    first, last = int(numbers[0]), int(numbers[-1])
    return slice(first, last + 1) if last - first + 1 == len(numbers) else numbers


def _few(fit: JointFit) -> bool:
    n, _, width = fit.shape
    return n <= FEW * width
