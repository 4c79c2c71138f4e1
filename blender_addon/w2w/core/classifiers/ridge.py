# SPDX-License-Identifier: GPL-3.0-or-later
"""Class-balanced ridge classifier for all sensors: closed form, all folds from one set of Gram matrices."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from threadpoolctl import threadpool_limits

ALPHAS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""Ridges on a logarithmic grid, in units of a standardised feature's variance."""
INNER_FOLDS = 4
"""Parts that a fold's training windows are dealt to, to choose its ridge."""
GRAM_BLOCK_BYTES = 64 * 2**20
"""Memory for products of segments at a time, a thread."""


@dataclass(frozen=True)
class Ridge:
    """Linear least squares onto one-hot labels, the classes weighing the same, with a ridge.

    Every feature is standardised by the training windows of its fold. The largest
    output names the activity. With equal class weights this is linear discriminant
    analysis with equal priors and a ridge on the total covariance (Hastie, Buja and
    Tibshirani 1995, doi:10.1214/aos/1176324456).

    Parameters
    ----------
    alphas : tuple of float
        Ridges to choose from, in units of a standardised feature's variance. Each fold
        chooses by cross-validation within its own training windows, one ridge for all
        sensors, so that places differ by their signals alone.
    tuning_sensors : int
        Sensors, evenly taken, on which the choice rests.
    workers : int
        Threads.
    """

    alphas: tuple[float, ...] = ALPHAS
    tuning_sensors: int = 24
    workers: int = 2

    name: ClassVar[str] = "ridge"

    def predict_folds(
        self,
        features: np.ndarray,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Name every test window by the model of the folds it does not belong to.

        Parameters
        ----------
        features : ndarray, shape (W, N, D)
        labels : ndarray of int, shape (W,)
            Activity of each window, 0 to A - 1.
        fold : ndarray of int, shape (W,)
            Fold of each window; -1 for windows that every fold trains on.
        is_test : ndarray of bool, shape (W,)
        progress : callable, optional
            Told the fraction done.

        Returns
        -------
        ndarray, shape (sum of is_test, N), int16
        """
        grams = _Grams(labels, fold)
        tested = np.flatnonzero(is_test)
        n_sensors = features.shape[1]
        chosen = self._choose_alphas(features, grams, labels, fold, is_test)
        folds = np.unique(fold[tested])
        weights = grams.training_weights([{f} for f in folds])
        of_fold = [np.flatnonzero(fold[tested] == f) for f in folds]
        predictions = np.empty((len(tested), n_sensors), dtype=np.int16)

        def name_windows(sensor: int) -> None:
            inputs = features[:, sensor]
            models = grams.models(inputs, weights, chosen[:, None])
            for model, rows in zip(models, of_fold, strict=True):
                predictions[rows, sensor] = model[0].predict(inputs[tested[rows]])

        with threadpool_limits(1), ThreadPoolExecutor(self.workers) as pool:
            for done, _ in enumerate(pool.map(name_windows, range(n_sensors)), start=1):
                if progress is not None:
                    progress(done / n_sensors)
        return predictions

    def _choose_alphas(
        self, features: np.ndarray, grams: _Grams, labels: np.ndarray, fold: np.ndarray, is_test: np.ndarray
    ) -> np.ndarray:
        """The ridge of each fold, chosen by cross-validation among the other folds."""
        folds = np.unique(fold[is_test])
        if len(folds) < 3 or len(self.alphas) == 1:
            return np.full(len(folds), self.alphas[len(self.alphas) // 2])
        held_out = [(f, part) for f in folds for part in _parts(folds[folds != f])]
        weights = grams.training_weights([{f, *part} for f, part in held_out])
        rows = [np.flatnonzero(is_test & np.isin(fold, part)) for _, part in held_out]
        alphas = np.tile(self.alphas, (len(held_out), 1))
        sensors = np.unique(np.linspace(0, features.shape[1] - 1, self.tuning_sensors).astype(int))

        def accuracies(sensor: int) -> np.ndarray:
            inputs = features[:, sensor]
            models = grams.models(inputs, weights, alphas)
            return np.array(
                [
                    [_balanced_accuracy(labels[r], model.predict(inputs[r])) for model in row]
                    for row, r in zip(models, rows, strict=True)
                ]
            )

        with threadpool_limits(1), ThreadPoolExecutor(self.workers) as pool:
            scores = sum(pool.map(accuracies, sensors))
        outer = np.array([f for f, _ in held_out])
        by_fold = np.stack([scores[outer == f].mean(axis=0) for f in folds])
        return np.asarray(self.alphas)[by_fold.argmax(axis=1)]


@dataclass(frozen=True, eq=False)
class _Model:
    """Scores are inputs @ slopes + offset; NaN-free, -inf for classes never seen."""

    slopes: np.ndarray
    offset: np.ndarray

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        return (inputs @ self.slopes + self.offset).argmax(axis=1)


class _Grams:
    """Gram matrices of (fold, class) segments, added up with any fold's class weights.

    With equal class weights the training Gram matrix of a set of folds is
    sum over its segments of X_s' X_s / (windows of the class in the set), so each
    segment's product is formed once, whatever the number of folds.
    """

    def __init__(self, labels: np.ndarray, fold: np.ndarray) -> None:
        self.n_classes = int(labels.max()) + 1
        code = (fold - fold.min()) * self.n_classes + labels
        self.order = np.argsort(code, kind="stable")
        codes, self.start, self.size = np.unique(code[self.order], return_index=True, return_counts=True)
        self.label = codes % self.n_classes
        self.fold = codes // self.n_classes + fold.min()

    def training_weights(self, excluded: list[set[int]]) -> np.ndarray:
        """(len(excluded), segments): weight of one window when these folds are left out."""
        trained = np.array([~np.isin(self.fold, list(folds)) for folds in excluded])
        is_of = self.label[:, None] == np.arange(self.n_classes)
        windows = (trained * self.size) @ is_of
        with np.errstate(divide="ignore"):
            return np.where(trained, 1.0 / windows[:, self.label], 0.0)

    def models(self, inputs: np.ndarray, weights: np.ndarray, alphas: np.ndarray) -> list[list[_Model]]:
        """Fit a model for each row of `weights` (K, segments) and each ridge in `alphas` (K, R)."""
        centre, scale = inputs.mean(axis=0, dtype=np.float64), inputs.std(axis=0, dtype=np.float64)
        scale = np.where(scale > 0, scale, 1.0)
        augmented = np.ones((len(inputs), inputs.shape[1] + 1))
        augmented[:, :-1] = (inputs[self.order] - centre) / scale
        gram, sums = self._moments(augmented, weights)
        fits = zip(gram, sums, alphas, strict=True)
        return [[_solve(g, s, alpha, centre, scale) for alpha in ridges] for g, s, ridges in fits]

    def _moments(self, augmented: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Weighted Gram matrices (K, D + 1, D + 1) and class sums (K, A, D + 1)."""
        n_models, width = len(weights), augmented.shape[1]
        gram = np.zeros((n_models, width * width))
        segment_sums = np.add.reduceat(augmented, self.start, axis=0)
        block = max(1, GRAM_BLOCK_BYTES // (8 * width * width))
        for first in range(0, len(self.start), block):
            segments = range(first, min(first + block, len(self.start)))
            rows = [augmented[self.start[s] : self.start[s] + self.size[s]] for s in segments]
            products = np.stack([r.T @ r for r in rows]).reshape(len(rows), -1)
            gram += weights[:, segments.start : segments.stop] @ products
        is_of = self.label == np.arange(self.n_classes)[:, None]
        sums = (weights[:, None, :] * is_of) @ segment_sums
        return gram.reshape(n_models, width, width), sums


def _solve(gram: np.ndarray, sums: np.ndarray, alpha: float, centre: np.ndarray, scale: np.ndarray) -> _Model:
    """Ridge on features standardised by the training windows, written for raw inputs."""
    total = gram[-1, -1]
    mean = gram[-1, :-1] / total
    covariance = gram[:-1, :-1] / total - np.outer(mean, mean)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    deviation = np.where(deviation > 1e-6, deviation, np.inf)
    correlation = covariance / np.outer(deviation, deviation)
    prior = sums[:, -1] / total
    target = ((sums[:, :-1] / total - np.outer(prior, mean)) / deviation).T
    correlation[np.diag_indices_from(correlation)] += alpha
    slopes = cho_solve(cho_factor(correlation, overwrite_a=True), target) / deviation[:, None]
    offset = np.where(prior > 0, prior - mean @ slopes, -np.inf)
    slopes /= scale[:, None]
    return _Model(slopes, offset - centre @ slopes)


def _parts(folds: np.ndarray) -> list[np.ndarray]:
    """Deal folds to at most INNER_FOLDS parts."""
    return [folds[first::INNER_FOLDS] for first in range(min(INNER_FOLDS, len(folds)))]


def _balanced_accuracy(truth: np.ndarray, named: np.ndarray) -> float:
    hits = np.bincount(truth, weights=truth == named)
    windows = np.bincount(truth)
    return float((hits[windows > 0] / windows[windows > 0]).mean())
