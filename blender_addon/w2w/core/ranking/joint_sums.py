# SPDX-License-Identifier: GPL-3.0-or-later
"""All trainings of a cross-validation at once, on patches worn and one more: what they share is done once.

The windows are dealt to parts that every training has whole or not at all, such as folds. Products of
features are formed once a part; those of a training are sums of them. So that single precision does for
these, features are taken about the class means of all windows, which those of a training lie close to.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from ..blas import add_square, multiply, multiply_lower, solve_positive
from .class_sums import averaging, summing
from .classifiers.discriminant import deviation, with_ridge
from .joint_fit import JointFit


class _Sums(NamedTuple):
    """Features (W, D) of a patch or of several side by side, and sums over each of T trainings.

    Attributes
    ----------
    about : ndarray, shape (W, D)
        About the class means of all windows, part by part.
    apart : ndarray, shape (T, A, D)
        The trainings' class means about these, times the roots of the classes' windows.
    scale : ndarray, shape (T, D)
        Deviation within classes; infinite for features that never vary.
    gram : ndarray, shape (T, D, D)
        Of the windows trained on about their class means, in units of `scale`: the upper triangle.
    means : ndarray, shape (T, A, D)
        Class means in units of `scale`.
    """

    about: np.ndarray
    apart: np.ndarray
    scale: np.ndarray
    gram: np.ndarray
    means: np.ndarray


class _Worn(NamedTuple):
    """What patches worn say in one training.

    Attributes
    ----------
    inverse : ndarray, shape (K, K)
        Of the lower Cholesky factor of their Gram matrix with the ridge.
    means, tested : ndarray, shape (A, K) and (v, K)
        Class means and windows tested, multiplied by it.
    scores : ndarray, shape (v, A)
    norms : ndarray, shape (A,)
        Squared lengths of the class means.
    """

    inverse: np.ndarray
    means: np.ndarray
    tested: np.ndarray
    scores: np.ndarray
    norms: np.ndarray


class Worn(NamedTuple):
    """Patches worn: their sums, and what they say in each training."""

    sums: _Sums
    said: tuple[_Worn, ...]


class JointSums:
    """The trainings of a cross-validation.

    Parameters
    ----------
    features, labels
        As for `JointScores`.
    fits : sequence of JointFit
        One a training.
    """

    def __init__(self, features: np.ndarray, labels: np.ndarray, fits: Sequence[JointFit]) -> None:
        self._features, self._fits = features, fits
        has = np.zeros((len(fits), len(labels)), dtype=bool)
        for row, fit in zip(has, fits, strict=True):
            row[fit.training.trained] = True
        used = np.flatnonzero(has.any(axis=0))
        kinds, part = np.unique(has[:, used], axis=1, return_inverse=True)
        self._of_part = kinds.astype(np.float32)
        order = np.lexsort((labels[used], part.ravel()))
        self._windows, part = used[order], part.ravel()[order]
        self._labels = labels[self._windows]
        n_parts, n_activities = kinds.shape[1], fits[0].n_activities
        ends = np.searchsorted(part, np.arange(n_parts + 1))
        self._parts = [slice(*pair) for pair in pairwise(ends)]
        self._of_cell = summing(part * n_activities + self._labels, n_parts * n_activities)
        self._summed_parts = summing(part, n_parts)
        self._counts = self._summed(np.ones((len(self._windows), 1), dtype=np.float32))[..., 0]
        self._average = averaging(self._labels, n_activities)

    def wear(self, patches: Sequence[int]) -> Worn | None:
        """What patches say where one more will be worn."""
        if not len(patches):
            return None
        features = np.concatenate([self._features[patch] for patch in patches], axis=1)
        sums = self._sums(features)
        said = [
            self._said(fit, features, sums, number, len(patches) + 1) for number, fit in enumerate(self._fits)
        ]
        return Worn(sums, tuple(said))

    def add(self, worn: Worn | None, patch: int) -> np.ndarray:
        """Scores (V, A) by the patches worn and one more, training by training."""
        features = self._features[patch]
        own = self._sums(features)
        count = 1 if worn is None else worn.sums.scale.shape[1] // features.shape[1] + 1
        shared = None if worn is None else self._shared(worn.sums, own)
        scores = []
        for number, fit in enumerate(self._fits):
            gram, means = with_ridge(own.gram[number], fit.ridge * count), own.means[number]
            if worn is not None:
                said = worn.said[number]
                crossed = multiply_lower(said.inverse, shared[number])
                add_square(gram, crossed, -1.0)
                means = means - multiply(said.means, crossed)
            slopes = solve_positive(gram, means)
            found = multiply(features[fit.training.tested], (slopes / own.scale[number]).T)
            norms = (means * slopes).sum(axis=1)
            if worn is not None:
                found += said.scores - multiply(said.tested, multiply(crossed, slopes.T))
                norms += said.norms
            scores.append(fit.offset(found, norms))
        return np.concatenate(scores)

    def _sums(self, features: np.ndarray) -> _Sums:
        """Sums of features (W, D)."""
        inputs = features[self._windows]
        centre = self._average @ inputs
        about = inputs - centre[self._labels]
        roots = np.sqrt(np.maximum(self._counts, 1))[..., None]
        apart = self._summed(about) / roots
        gram = np.zeros((len(self._parts), *(features.shape[1],) * 2), dtype=np.float32)
        for of_part, rows in zip(gram, self._parts, strict=True):
            add_square(of_part, about[rows])
        gram = self._of_trainings(gram)
        for of_training, means in zip(gram, apart, strict=True):
            add_square(of_training, means, -1.0)
        trained = self._counts.sum(axis=1)[:, None]
        whole = self._of_trainings(self._summed_parts @ np.square(inputs)) / trained
        scale = deviation(np.einsum("tdd->td", gram) / trained, whole).astype(np.float32)
        gram /= scale[:, :, None]
        gram /= scale[:, None]
        return _Sums(about, apart, scale, gram, (centre + apart / roots) / scale[:, None])

    def _shared(self, worn: _Sums, own: _Sums) -> np.ndarray:
        """Products (T, K, D) of the features worn with a patch's, as in `_Sums.gram`."""
        shared = np.empty((len(self._parts), worn.about.shape[1], own.about.shape[1]), dtype=np.float32)
        for of_part, rows in zip(shared, self._parts, strict=True):
            multiply(worn.about[rows].T, own.about[rows], out=of_part)
        shared = self._of_trainings(shared)
        for of_training, means_worn, means in zip(shared, worn.apart, own.apart, strict=True):
            of_training -= multiply(means_worn.T, means)
        shared /= worn.scale[:, :, None]
        shared /= own.scale[:, None]
        return shared

    def _said(self, fit: JointFit, features: np.ndarray, sums: _Sums, number: int, count: int) -> _Worn:
        """What features worn (W, K) say in a training, with the ridge of so many patches."""
        upper = with_ridge(sums.gram[number].copy(), fit.ridge * count)
        lower = cholesky(upper, overwrite_a=True, check_finite=False).T
        identity = np.eye(len(lower), dtype=np.float32)
        inverse = solve_triangular(lower, identity, lower=True, check_finite=False)
        means = multiply(sums.means[number], inverse.T)
        tested = multiply(features[fit.training.tested] / sums.scale[number], inverse.T)
        norms = np.einsum("ak,ak->a", means, means)
        return _Worn(inverse, means, tested, multiply(tested, means.T), norms)

    def _summed(self, rows: np.ndarray) -> np.ndarray:
        """Sums (T, A, D) of rows (W, D) over each training's windows of each class."""
        return self._of_trainings((self._of_cell @ rows).reshape(len(self._parts), -1, rows.shape[1]))

    def _of_trainings(self, of_parts: np.ndarray) -> np.ndarray:
        """Sums (T, ...) over each training's parts, of sums (P, ...) over the windows of each part."""
        sums = multiply(self._of_part, of_parts.reshape(len(of_parts), -1))
        return sums.reshape(-1, *of_parts.shape[1:])
