# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear discriminant analysis with a ridge, solved for features or, where they are fewer, for windows."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

import numpy as np
from scipy.sparse import csr_array

from ...blas import add_square, multiply, solve_positive

LEAST_WITHIN = 1e-6
"""Smallest variance within classes, as a share of all, that rounding leaves meaningful."""
NEVER_VARIES = 1e-12
"""Variance of a feature that is the same in every training window."""
KEPT_OUT = 1e30
"""Unit of the ridge if a feature never varies: large enough to switch it off, small enough to stay finite."""
MOST_LARGER = 6
"""Times that the ridge is made ten times as large where rounding leaves a matrix that cannot be solved."""
FEW = 1.2
"""Windows per feature up to which the dual is solved (for windows): half the time at 1 and below."""


def few(n_windows: np.ndarray, width: int) -> np.ndarray:
    """Whether there are few training windows for `width` features."""
    return n_windows <= FEW * width


def summing(group: np.ndarray, n_groups: int) -> csr_array:
    """Sparse matrix (n_groups, W), float32, that adds up the rows of each group: a tenth of the time.

    `group` (W,) is that of each row, from 0 to `n_groups` - 1.
    """
    ones = np.ones(len(group), dtype=np.float32)
    return csr_array((ones, (group, np.arange(len(group)))), shape=(n_groups, len(group)))


def averaging(group: np.ndarray, n_groups: int) -> csr_array:
    """Sparse matrix (n_groups, W), float32, that takes the mean of each group; 0 for a group without rows."""
    share = (1 / np.maximum(np.bincount(group, minlength=n_groups), 1)).astype(np.float32)
    return csr_array((share[group], (group, np.arange(len(group)))), shape=(n_groups, len(group)))


class Discriminant:
    """P trainings, of several patches or on several sets of windows, with several ridges.

    Built from class means (P, A, D), training windows per class (A,) or (P, A) (a class with none is never
    predicted) and slopes (P, A, D), one per ridge, in single precision.
    """

    def __init__(self, means: np.ndarray, windows: np.ndarray, slopes: Iterable[np.ndarray]) -> None:
        self._slopes = np.stack(tuple(slopes), axis=2)
        self.offsets = -0.5 * np.einsum("pad,pard->par", means, self._slopes)
        self.offsets[np.broadcast_to(windows == 0, means.shape[:2])] = -np.inf

    @classmethod
    def by_features(
        cls, within: np.ndarray, whole: np.ndarray, means: np.ndarray, windows: np.ndarray, ridges: np.ndarray
    ) -> Discriminant:
        """Train from sums over the training windows of P trainings, in single precision, by `ridges` (P, R).

        `within` (P, D, D) holds products of features about their class means, the upper triangle; `whole`
        (P, D) squares of features about whatever `means` (P, A, D) are about; `windows` are (P, A).
        """
        count = windows.sum(axis=1, dtype=np.float32)[:, None]
        inside = np.einsum("pdd->pd", within) / count
        unit = np.minimum(count * deviation(inside, whole / count) ** 2, KEPT_OUT)
        aims = count[..., None] * means
        solved = (
            np.stack([*map(_solved, within, ridge[:, None] * unit, aims)])
            for ridge in ridges.T.astype(np.float32)
        )
        return cls(means, windows, solved)

    @classmethod
    def by_windows(cls, inputs: np.ndarray, member: np.ndarray, ridges: np.ndarray) -> Discriminant:
        """Train from windows (P, n, D), their classes as rows (n, A) of ones and zeros, and ridges.

        By Woodbury's identity a matrix of windows is solved, not of features (Saunders, Gammerman and
        Vovk 1998). Several patches at once take a third of the time.
        """
        count, windows = np.float32(len(member)), member.sum(axis=0)
        means = (member / np.maximum(windows, 1)).T @ inputs
        within = inputs - member @ means
        scale = deviation(*(np.einsum("pnd,pnd->pd", rows, rows) / count for rows in (within, inputs)))
        scale = scale[:, None]
        scaled, within = means / scale, within / scale
        kernels = np.zeros((len(inputs), len(member), len(member)), dtype=np.float32)
        for kernel, rows in zip(kernels, within, strict=True):
            add_square(kernel, rows.T)
        kernels /= count
        seen = scaled @ within.swapaxes(1, 2)

        def slopes(ridge: float) -> np.ndarray:
            pairs = zip(kernels, seen, strict=True)
            solved = [solve_positive(with_ridge(kernel.copy(), ridge), aims) for kernel, aims in pairs]
            shared = np.stack(solved) @ within
            return (scaled - shared / count) / (np.float32(ridge) * scale)

        return cls(means, windows, map(slopes, ridges))

    def scores(self, training: int, inputs: np.ndarray) -> np.ndarray:
        """Scores (A, ridges, v) of windows (v, D) by one of the trainings."""
        slopes, offsets = self._slopes[training], self.offsets[training]
        scores = multiply(slopes.reshape(-1, inputs.shape[1]), inputs.T).reshape(*offsets.shape, -1)
        return np.add(scores, offsets[..., None], out=scores)


def _solved(within: np.ndarray, ridge: np.ndarray, aims: np.ndarray) -> np.ndarray:
    """Solve with a ridge, which keeps the matrix so well conditioned that single precision does.

    Where it does not, as for features that vary in a few windows alone, the ridge is ten times as large.
    """
    for _ in range(MOST_LARGER):
        with suppress(np.linalg.LinAlgError):
            return solve_positive(with_ridge(within.copy(), ridge), aims)
        ridge = 10 * ridge
    return solve_positive(with_ridge(within.copy(), ridge), aims)


def deviation(within: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Standard deviation from the variances within classes and of all; infinite if a feature never varies."""
    variance = np.maximum(within, LEAST_WITHIN * whole)
    return np.sqrt(np.where(variance > NEVER_VARIES, variance, np.inf))


def with_ridge(matrix: np.ndarray, ridge: float | np.floating | np.ndarray) -> np.ndarray:
    """The matrix itself, with the ridge, or one for each row, added to its diagonal."""
    diagonal = np.einsum("ii->i", matrix)
    diagonal += np.asarray(ridge, dtype=np.float32)
    return matrix
