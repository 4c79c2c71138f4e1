# SPDX-License-Identifier: GPL-3.0-or-later
"""Ridge discriminant analysis for all sensors: closed form, all folds from one set of Gram matrices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from threadpoolctl import threadpool_limits

from ...blas import solve_positive
from ..halves import Plan, Split, plan
from ..inputs import BLOCK_BYTES, PatchBlocks, as_blocks, spans

ALPHAS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Ridges on a logarithmic grid, in units of a feature's variance within classes."""
STEADY = (0.05,)
"""Ridges that the map by which patches are chosen is averaged over beside the chosen one: which of several
that do equally well is chosen moves a map as much as other clips do."""
INNER_FOLDS = 4
"""Parts that a fold's training windows are dealt to, to choose its ridge."""
LEAST_WITHIN = 1e-6
"""Smallest variance within classes, as a share of all, that rounding leaves meaningful."""
NEVER_VARIES = 1e-12
"""Variance of a feature that is the same in every training window."""


@dataclass(frozen=True)
class Ridge:
    """Linear discriminant analysis with a ridge and equal priors.

    Least squares onto class indicators with a ridge finds the same directions, but naming
    the largest output masks classes that lie between others when there are many; the
    discriminant rule does not (Hastie, Tibshirani and Buja 1994,
    doi:10.1080/01621459.1994.10476866; Hastie, Buja and Tibshirani 1995,
    doi:10.1214/aos/1176324456).

    Every feature is scaled by its deviation within classes in the training windows. Gram
    matrices and class sums are formed once a block of windows; those of any training set
    are sums of them.

    Parameters
    ----------
    alphas : tuple of float
        Ridges to choose from, in units of a feature's variance within classes. Each fold
        chooses by cross-validation within its own training windows, one ridge for all
        sensors, so that patches differ by their signals alone: the largest within one standard
        error of the best (Breiman et al. 1984).
    tuning_sensors : int
        Sensors, evenly taken, on which the choice rests.
    seed : int
        Not used: nothing is drawn.
    workers : int
        Threads.
    block_bytes : int
        Features held at a time; changes nothing but memory.
    """

    alphas: tuple[float, ...] = ALPHAS
    tuning_sensors: int = 12
    seed: int = 0
    workers: int = 2
    block_bytes: int = BLOCK_BYTES

    name: ClassVar[str] = "ridge"
    inputs: ClassVar[str] = "features"

    def predict_folds(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Name every test window by the model of the folds it does not belong to.

        Parameters
        ----------
        features : ndarray or PatchBlocks, shape (W, N, D)
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
        work = plan(labels, np.arange(len(labels)), fold, is_test, halvings=0)
        position = np.cumsum(is_test) - 1
        predictions = np.empty((int(is_test.sum()), as_blocks(features).shape[1]), dtype=np.int16)

        def name_windows(sensor: int, scores: list[np.ndarray]) -> None:
            for split, (of_split,) in zip(work.splits, scores, strict=True):
                predictions[position[split.tested], sensor] = of_split.argmax(axis=1)

        alphas = self.choose_alphas(features, labels, fold, is_test)[:, None]
        self.score_splits(features, labels, work.block, work.splits, alphas, name_windows, progress)
        return predictions

    def settings(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        trials: Plan,
    ) -> np.ndarray:
        """Ridges of each split of a plan, shape (splits, ridges): the one chosen, then `STEADY`."""
        by_fold = self.choose_alphas(features, labels, fold, is_test)
        chosen = np.full(len(trials.splits), np.median(by_fold))
        chosen[list(trials.whole.splits)] = by_fold
        return np.column_stack([chosen, *(np.full(len(chosen), ridge) for ridge in STEADY)])

    def score_splits(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        block: np.ndarray,
        splits: Sequence[Split],
        alphas: np.ndarray,
        receive: Callable[[int, list[np.ndarray]], None],
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Score the activities in the tested windows of each split.

        Parameters
        ----------
        features, labels, progress
            As for `predict_folds`.
        block : ndarray of int, shape (W,)
            From 0, as `halves.plan` gives them.
        splits : sequence of Split
        alphas : ndarray, shape (splits, ridges)
        receive : callable
            Given each sensor's number and its scores (ridges, windows tested, A) by split, in any
            order and from several threads.
        """
        source = as_blocks(features)
        n_sensors = source.shape[1]
        sums = _Splits(labels, block, splits)

        def score(sensor: int, inputs: np.ndarray) -> None:
            receive(sensor, list(sums.scores(inputs, alphas)))

        with threadpool_limits(1), ThreadPoolExecutor(self.workers) as pool:
            for first, last in spans(source, self.block_bytes):
                held = source.patches(first, last).swapaxes(0, 1)
                for done, _ in enumerate(pool.map(score, range(first, last), held), start=first + 1):
                    if progress is not None:
                        progress(done / n_sensors)
                del held  # before the next is read

    def choose_alphas(
        self, features: np.ndarray | PatchBlocks, labels: np.ndarray, fold: np.ndarray, is_test: np.ndarray
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
        names, block = np.unique(fold, return_inverse=True)
        pairs = [(f, part) for f in folds for part in _parts(folds[folds != f])]
        splits = [
            Split(np.flatnonzero(~np.isin(names, [f, *part])), np.flatnonzero(is_test & np.isin(fold, part)))
            for f, part in pairs
        ]
        sums = _Splits(labels, block, splits)
        alphas = np.tile(self.alphas, (len(pairs), 1))
        source = as_blocks(features)
        sensors = np.unique(np.linspace(0, source.shape[1] - 1, self.tuning_sensors).astype(int))

        def accuracies(sensor: int) -> np.ndarray:
            scores = sums.scores(source.patches(sensor, sensor + 1)[:, 0], alphas)
            return np.array(
                [
                    [_balanced_accuracy(labels[split.tested], one.argmax(axis=1)) for one in by_ridge]
                    for split, by_ridge in zip(splits, scores, strict=True)
                ]
            )

        with threadpool_limits(1), ThreadPoolExecutor(self.workers) as pool:
            scores = np.mean(list(pool.map(accuracies, sensors)), axis=0)
        outer = np.array([f for f, _ in pairs])
        return np.array([self._steadiest(scores[outer == f]) for f in folds])

    def _steadiest(self, scores: np.ndarray) -> float:
        """The largest ridge within one standard error of the best, of scores (parts, ridges)."""
        mean = scores.mean(axis=0)
        best = int(mean.argmax())
        lag = scores[:, [best]] - scores
        error = lag.std(axis=0, ddof=1) / np.sqrt(len(scores)) if len(scores) > 1 else np.zeros(len(mean))
        good = np.flatnonzero(lag.mean(axis=0) <= error)
        return self.alphas[int(good.max())]


class _Splits:
    """Sums over blocks of windows, from which every split's training set is made."""

    def __init__(self, labels: np.ndarray, block: np.ndarray, splits: Sequence[Split]) -> None:
        self.n_classes = int(labels.max()) + 1
        self.rows = [np.flatnonzero(block == b) for b in range(int(block.max()) + 1)]
        self.indicators = [np.eye(self.n_classes)[labels[rows]] for rows in self.rows]
        self.tested = [split.tested for split in splits]
        self.trained = np.zeros((len(splits), len(self.rows)))
        for member, split in zip(self.trained, splits, strict=True):
            member[split.train] = 1.0

    def scores(self, inputs: np.ndarray, alphas: np.ndarray) -> Iterator[np.ndarray]:
        """Scores (ridges, windows tested, A) of each split, for each ridge of its row of `alphas`."""
        inputs = inputs - inputs.mean(axis=0)
        width = inputs.shape[1]
        grams = np.empty((len(self.rows), width, width))
        sums = np.empty((len(self.rows), self.n_classes, width))
        for number, (rows, indicator) in enumerate(zip(self.rows, self.indicators, strict=True)):
            part = inputs[rows].astype(np.float64)  # of one block at a time, which bounds memory
            np.matmul(part.T, part, out=grams[number])
            np.matmul(indicator.T, part, out=sums[number])
        windows = np.stack([one.sum(axis=0) for one in self.indicators])
        kept = [
            (self.trained @ of_block.reshape(len(of_block), -1)).reshape(-1, *of_block.shape[1:])
            for of_block in (grams, sums, windows)
        ]
        for *of_split, rows, ridges in zip(*kept, self.tested, alphas, strict=True):
            yield _Discriminant(*of_split).scores(inputs[rows], ridges)


class _Discriminant:
    """Linear discriminant analysis from a Gram matrix (D, D), class sums (A, D) and counts (A,)."""

    def __init__(self, gram: np.ndarray, sums: np.ndarray, windows: np.ndarray) -> None:
        self.seen = windows > 0
        means = sums / np.maximum(windows, 1)[:, None]
        within = (gram - sums.T @ means) / windows.sum()
        variance = np.maximum(np.diag(within), LEAST_WITHIN * np.diag(gram) / windows.sum())
        self.scale = np.sqrt(np.where(variance > NEVER_VARIES, variance, np.inf))
        # a ridge keeps the matrix so well conditioned that single precision does
        self.means = (means / self.scale).astype(np.float32)
        self.correlation = (within / np.outer(self.scale, self.scale)).astype(np.float32)

    def scores(self, inputs: np.ndarray, ridges: np.ndarray) -> np.ndarray:
        scaled = (inputs / self.scale).astype(np.float32)
        scores = np.empty((len(ridges), len(inputs), len(self.means)), dtype=np.float32)
        for ridge, out in zip(ridges, scores, strict=True):
            matrix = self.correlation.copy()
            matrix.flat[:: len(matrix) + 1] += np.float32(ridge)
            slopes = solve_positive(matrix, self.means)
            offset = np.where(self.seen, -0.5 * (self.means * slopes).sum(axis=1), -np.inf)
            np.matmul(scaled, slopes.T, out=out)
            out += offset.astype(np.float32)
        return scores


def _parts(folds: np.ndarray) -> list[np.ndarray]:
    """Deal folds to at most INNER_FOLDS parts."""
    return [folds[first::INNER_FOLDS] for first in range(min(INNER_FOLDS, len(folds)))]


def _balanced_accuracy(truth: np.ndarray, named: np.ndarray) -> float:
    hits = np.bincount(truth, weights=truth == named)
    windows = np.bincount(truth)
    return float((hits[windows > 0] / windows[windows > 0]).mean())
