# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear discriminant analysis with a ridge, solved for features or, where they are fewer, for windows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...blas import add_square, multiply, solve_positive

LEAST_WITHIN = 1e-6
"""Smallest variance within classes, as a share of all, that rounding leaves meaningful."""
NEVER_VARIES = 1e-12
"""Variance of a feature that is the same in every training window."""
FEW = 1.2
"""Windows for each feature up to which windows are solved for: half the time at 1 and below."""


def few(n_windows: np.ndarray, width: int) -> np.ndarray:
    """Of numbers of windows trained on, which are few for so many features."""
    return n_windows <= FEW * width


class Discriminant:
    """A training, with several ridges.

    Parameters
    ----------
    scale : ndarray, shape (D,), float32
        Deviation of the features within classes.
    means : ndarray, shape (A, D), float32
        Class means in units of it.
    windows : ndarray, shape (A,)
        Windows trained on; a class without any is never named.
    slopes : iterable of ndarray, shape (A, D), float32
        One a ridge, in units of `scale`.
    """

    def __init__(
        self, scale: np.ndarray, means: np.ndarray, windows: np.ndarray, slopes: Iterable[np.ndarray]
    ) -> None:
        self._lines = []
        for of_ridge in slopes:
            offset = np.where(windows > 0, -0.5 * (means * of_ridge).sum(axis=1), -np.inf)
            self._lines.append((of_ridge / scale, offset.astype(np.float32)))

    @classmethod
    def by_features(
        cls,
        within: np.ndarray,
        whole: np.ndarray,
        means: np.ndarray,
        windows: np.ndarray,
        ridges: np.ndarray,
    ) -> Discriminant:
        """From sums over the windows trained on, in single precision; `within` is overwritten.

        Parameters
        ----------
        within : ndarray, shape (D, D)
            Products of features about their class means: the upper triangle.
        whole : ndarray, shape (D,)
            Squares of features about whatever the class means are about.
        means : ndarray, shape (A, D)
        windows : ndarray, shape (A,)
        ridges : ndarray
        """
        within /= windows.sum()
        scale = deviation(np.diag(within), whole / windows.sum()).astype(np.float32)
        # a ridge keeps the matrix so well conditioned that single precision does
        within /= scale[:, None]
        within /= scale
        means = means / scale
        slopes = (solve_positive(with_ridge(within.copy(), ridge), means) for ridge in ridges)
        return cls(scale, means, windows, slopes)

    @classmethod
    def by_windows(cls, inputs: np.ndarray, member: np.ndarray, ridges: np.ndarray) -> Discriminant:
        """From windows (n, D), their classes as rows (n, A) of ones and zeros, and ridges.

        By Woodbury's identity a matrix of windows is solved, not of features (Saunders, Gammerman and
        Vovk 1998).
        """
        count, windows = np.float32(len(inputs)), member.sum(axis=0)
        means = (member / np.maximum(windows, 1)).T @ inputs
        within = inputs - member @ means
        scale = deviation(*(np.einsum("nd,nd->d", rows, rows) / count for rows in (within, inputs)))
        means, within = means / scale, within / scale
        kernel = np.zeros((len(inputs),) * 2, dtype=np.float32)
        add_square(kernel, within.T)
        kernel /= count
        seen = means @ within.T

        def slopes(ridge: float) -> np.ndarray:
            shared = solve_positive(with_ridge(kernel.copy(), ridge), seen) @ within
            return (means - shared / count) / np.float32(ridge)

        return cls(scale, means, windows, map(slopes, ridges))

    def scores(self, inputs: np.ndarray) -> np.ndarray:
        """Scores (ridges, v, A) of windows (v, D)."""
        scores = np.empty((len(self._lines), len(inputs), len(self._lines[0][1])), dtype=np.float32)
        for of_ridge, (slopes, offset) in zip(scores, self._lines, strict=True):
            multiply(inputs, slopes.T, out=of_ridge)
            of_ridge += offset
        return scores


def deviation(within: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Deviation from the variances within classes and of all; infinite where a feature never varies."""
    variance = np.maximum(within, LEAST_WITHIN * whole)
    return np.sqrt(np.where(variance > NEVER_VARIES, variance, np.inf))


def with_ridge(matrix: np.ndarray, ridge: float) -> np.ndarray:
    """The matrix itself, the ridge added to its diagonal."""
    matrix.flat[:: len(matrix) + 1] += np.float32(ridge)
    return matrix
