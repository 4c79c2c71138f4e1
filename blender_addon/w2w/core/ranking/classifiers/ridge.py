# SPDX-License-Identifier: GPL-3.0-or-later
"""Ridge discriminant analysis for all sensors: closed form, all folds from one set of Gram matrices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from threadpoolctl import threadpool_limits

from ...blas import solve_positive
from ..inputs import BLOCK_BYTES, PlaceBlocks, as_blocks, spans

ALPHAS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Ridges on a logarithmic grid, in units of a feature's variance within classes."""
INNER_FOLDS = 4
"""Parts that a fold's training windows are dealt to, to choose its ridge."""
LEAST_WITHIN = 1e-6
"""Smallest variance within classes, as a share of all, that rounding leaves meaningful."""
NEVER_ACTIVE = 1e-12
"""Variance of a random unit that was not active in any training window."""


@dataclass(frozen=True)
class Ridge:
    """Linear discriminant analysis with a ridge and equal priors, on features and random ReLU units.

    Least squares onto class indicators with a ridge finds the same directions, but naming
    the largest output masks classes that lie between others when there are many; the
    discriminant rule does not (Hastie, Tibshirani and Buja 1994,
    doi:10.1080/01621459.1994.10476866; Hastie, Buja and Tibshirani 1995,
    doi:10.1214/aos/1176324456). The random units, drawn once for all sensors, let it bend
    (Huang, Zhu and Siew 2006, doi:10.1016/j.neucom.2005.12.126).

    Every feature is scaled by its deviation within classes in the training windows of its
    fold. Gram matrices and class sums are formed once a fold; those of any training set
    are sums of them.

    Parameters
    ----------
    alphas : tuple of float
        Ridges to choose from, in units of a feature's variance within classes. Each fold
        chooses by cross-validation within its own training windows, one ridge for all
        sensors, so that places differ by their signals alone.
    hidden : int
        Random units added to the features; 0 leaves the classifier linear.
    tuning_sensors : int
        Sensors, evenly taken, on which the choice rests.
    seed : int
        Decides the random units.
    workers : int
        Threads.
    block_bytes : int
        Features held at a time; changes nothing but memory.
    """

    alphas: tuple[float, ...] = ALPHAS
    hidden: int = 192
    tuning_sensors: int = 12
    seed: int = 0
    workers: int = 2
    block_bytes: int = BLOCK_BYTES

    name: ClassVar[str] = "ridge"
    inputs: ClassVar[str] = "features"

    def predict_folds(
        self,
        features: np.ndarray | PlaceBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Name every test window by the model of the folds it does not belong to.

        Parameters
        ----------
        features : ndarray or PlaceBlocks, shape (W, N, D)
            Of order one, as `window_features` gives them.
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
        places = as_blocks(features)
        n_sensors = places.shape[1]
        folds = np.unique(fold[is_test])
        alphas = self.choose_alphas(places, labels, fold, is_test)
        splits = _Splits(labels, fold, is_test, [(f,) for f in folds], [(f,) for f in folds])
        position = np.cumsum(is_test) - 1
        predictions = np.empty((int(is_test.sum()), n_sensors), dtype=np.int16)
        expand = self._layer(places.shape[2])

        def name_windows(sensor: int, inputs: np.ndarray) -> None:
            named = splits.predict(expand(inputs), alphas[:, None])
            for rows, by_alpha in zip(splits.tested, named, strict=True):
                predictions[position[rows], sensor] = by_alpha[0]

        with threadpool_limits(1), ThreadPoolExecutor(self.workers) as pool:
            for first, last in spans(places, self.block_bytes):
                block = places.places(first, last).swapaxes(0, 1)
                for done, _ in enumerate(pool.map(name_windows, range(first, last), block), start=first + 1):
                    if progress is not None:
                        progress(done / n_sensors)
        return predictions

    def choose_alphas(
        self, features: np.ndarray | PlaceBlocks, labels: np.ndarray, fold: np.ndarray, is_test: np.ndarray
    ) -> np.ndarray:
        """The ridge of each fold, chosen by cross-validation among the other folds.

        Parameters
        ----------
        features, labels, fold, is_test
            As for `predict_folds`.

        Returns
        -------
        ndarray, shape (folds tested,)
        """
        folds = np.unique(fold[is_test])
        if len(folds) < 3 or len(self.alphas) == 1:
            return np.full(len(folds), self.alphas[len(self.alphas) // 2])
        pairs = [(f, part) for f in folds for part in _parts(folds[folds != f])]
        splits = _Splits(
            labels, fold, is_test, [(f, *part) for f, part in pairs], [part for _, part in pairs]
        )
        alphas = np.tile(self.alphas, (len(pairs), 1))
        places = as_blocks(features)
        sensors = np.unique(np.linspace(0, places.shape[1] - 1, self.tuning_sensors).astype(int))
        expand = self._layer(places.shape[2])

        def accuracies(sensor: int) -> np.ndarray:
            named = splits.predict(expand(places.places(sensor, sensor + 1)[:, 0]), alphas)
            return np.array(
                [
                    [_balanced_accuracy(labels[rows], one) for one in by_alpha]
                    for rows, by_alpha in zip(splits.tested, named, strict=True)
                ]
            )

        with threadpool_limits(1), ThreadPoolExecutor(self.workers) as pool:
            scores = sum(pool.map(accuracies, sensors))
        outer = np.array([f for f, _ in pairs])
        by_fold = np.stack([scores[outer == f].mean(axis=0) for f in folds])
        return np.asarray(self.alphas)[by_fold.argmax(axis=1)]

    def _layer(self, width: int) -> Callable[[np.ndarray], np.ndarray]:
        """Features (W, D) -> features and random units (W, D + hidden), float32."""
        rng = np.random.default_rng(self.seed)
        slopes = (rng.normal(size=(width, self.hidden)) / np.sqrt(width)).astype(np.float32)
        offsets = rng.uniform(-1, 1, size=self.hidden).astype(np.float32)

        def expand(inputs: np.ndarray) -> np.ndarray:
            expanded = np.empty((len(inputs), width + self.hidden), dtype=np.float32)
            expanded[:, :width] = inputs
            np.matmul(expanded[:, :width], slopes, out=expanded[:, width:])
            np.maximum(expanded[:, width:] + offsets, 0, out=expanded[:, width:])
            return expanded

        return expand


class _Splits:
    """Training sets given by the folds they leave out, and the folds each is tested on."""

    def __init__(
        self,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        left_out: Sequence[Sequence[int]],
        tested: Sequence[Sequence[int]],
    ) -> None:
        folds = np.unique(fold)
        self.n_classes = int(labels.max()) + 1
        self.left_out = [np.flatnonzero(np.isin(folds, out)) for out in left_out]
        self.tested = [np.flatnonzero(is_test & np.isin(fold, test)) for test in tested]
        self.rows = [np.flatnonzero(fold == f) for f in folds]
        self.indicators = [np.eye(self.n_classes)[labels[rows]] for rows in self.rows]

    def predict(self, inputs: np.ndarray, alphas: np.ndarray) -> list[list[np.ndarray]]:
        """Classes of the tested windows of each split, for each ridge of its row of `alphas`.

        `inputs` are centred in place.
        """
        inputs -= inputs.mean(axis=0)
        width = inputs.shape[1]
        grams = np.empty((len(self.rows), width, width))
        sums = np.empty((len(self.rows), self.n_classes, width))
        for number, (rows, indicator) in enumerate(zip(self.rows, self.indicators, strict=True)):
            part = inputs[rows].astype(np.float64)  # of one fold at a time, which bounds memory
            np.matmul(part.T, part, out=grams[number])
            np.matmul(indicator.T, part, out=sums[number])
        windows = np.stack([one.sum(axis=0) for one in self.indicators])
        everything = [of_fold.sum(axis=0) for of_fold in (grams, sums, windows)]
        named = []
        for left_out, rows, ridges in zip(self.left_out, self.tested, alphas, strict=True):
            kept = (
                total - of_fold[left_out].sum(axis=0)
                for total, of_fold in zip(everything, (grams, sums, windows), strict=True)
            )
            named.append(_Discriminant(*kept).predict(inputs[rows], ridges))
        return named


class _Discriminant:
    """Linear discriminant analysis from a Gram matrix (D, D), class sums (A, D) and counts (A,)."""

    def __init__(self, gram: np.ndarray, sums: np.ndarray, windows: np.ndarray) -> None:
        self.seen = windows > 0
        means = sums / np.maximum(windows, 1)[:, None]
        within = (gram - sums.T @ means) / windows.sum()
        variance = np.maximum(np.diag(within), LEAST_WITHIN * np.diag(gram) / windows.sum())
        self.scale = np.sqrt(np.where(variance > NEVER_ACTIVE, variance, np.inf))
        self.means = means / self.scale
        self.correlation = within / np.outer(self.scale, self.scale)

    def predict(self, inputs: np.ndarray, ridges: np.ndarray) -> list[np.ndarray]:
        scaled = inputs / self.scale
        named = []
        for ridge in ridges:
            matrix = self.correlation.copy()
            matrix[np.diag_indices_from(matrix)] += ridge
            slopes = solve_positive(matrix, self.means)
            offset = np.where(self.seen, -0.5 * (self.means * slopes).sum(axis=1), -np.inf)
            named.append((scaled @ slopes.T + offset).argmax(axis=1))
        return named


def _parts(folds: np.ndarray) -> list[np.ndarray]:
    """Deal folds to at most INNER_FOLDS parts."""
    return [folds[first::INNER_FOLDS] for first in range(min(INNER_FOLDS, len(folds)))]


def _balanced_accuracy(truth: np.ndarray, named: np.ndarray) -> float:
    hits = np.bincount(truth, weights=truth == named)
    windows = np.bincount(truth)
    return float((hits[windows > 0] / windows[windows > 0]).mean())
