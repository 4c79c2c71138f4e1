# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 from counts, and how sure it is: a bootstrap over clips."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import rankdata

from .weights import mean_over

FEWEST_CLIPS = 5
"""Of fewer clips the bootstrap draws hardly anything but the same ones: its interval says nothing then."""

COUNT_BYTES = 12 * 2**20
"""Memory for the counts of the patches looked at at a time: of 5,000 clips and 30 activities 20 patches'.
Of more at a time the samples outgrow the processor's cache."""


@dataclass(frozen=True, eq=False)
class ClipCounts:
    """What F1 needs to know of each clip, so that resampling clips is one matrix product.

    Attributes
    ----------
    hit : ndarray, shape (C, N)
        Windows of the clip that sensor n named rightly.
    named : ndarray, shape (C, N, A)
        Windows of the clip that sensor n named a, rightly or not.
    size : ndarray, shape (C,)
        Windows of the clip.
    activity : ndarray, shape (C,)
        Index of its activity.
    """

    hit: np.ndarray
    named: np.ndarray
    size: np.ndarray
    activity: np.ndarray

    def confusion(self) -> np.ndarray:
        """Windows by sensor, true and named activity, shape (N, A, A), int32."""
        n_activities = self.named.shape[2]
        of = [self.named[self.activity == a].sum(axis=0) for a in range(n_activities)]
        return np.stack(of, axis=1).astype(np.int32)


class Bootstrap(NamedTuple):
    """Percentile intervals of F1 (N, A), of macro F1 (N,) and of the rank by it (N,; 1 is the
    best), and the macro F1 of every resample (B, N)."""

    f1_low: np.ndarray
    f1_high: np.ndarray
    mean_low: np.ndarray
    mean_high: np.ndarray
    rank_low: np.ndarray
    rank_high: np.ndarray
    mean_samples: np.ndarray


def count_by_clip(
    truth: np.ndarray, predictions: np.ndarray, clip: np.ndarray, n_activities: int
) -> ClipCounts:
    """Count the hits and the names given, clip by clip.

    Parameters
    ----------
    truth : ndarray of int, shape (W,)
    predictions : ndarray of int, shape (W, N)
    clip : array_like, shape (W,)
        Windows of one clip and several activities count as several clips.
    n_activities : int
    """
    return _count(predictions, _Units(truth, clip, n_activities))


def score_patches(
    truth: np.ndarray,
    predictions: np.ndarray,
    clip: np.ndarray,
    n_activities: int,
    n_resamples: int,
    level: float,
    seed: int,
    block: int | None = None,
    activity_weights: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, Bootstrap]:
    """F1 and confusion of every patch, and how sure they are; some patches at a time.

    The intervals are those of a percentile bootstrap over clips, within activities (Efron and
    Tibshirani 1993, chapter 13). The models are not trained again: what varies is which clips
    are tested, so the intervals say how far the result depends on the clips at hand, not on the
    draw of the folds. All patches see the same resamples.

    Parameters
    ----------
    truth, predictions, clip, n_activities
        As for `count_by_clip`.
    n_resamples : int
    level : float
        Confidence, between 0 and 1.
    seed : int
        Of the resamples.
    block : int
        Patches at a time, as many as `COUNT_BYTES` hold by default. Counts are whole numbers, so it
        changes no bit.
    activity_weights : ndarray, shape (n_activities,), optional
        What each activity counts in the macro F1; all alike by default.

    Returns
    -------
    f1 : ndarray, shape (N, A), float32
    confusion : ndarray, shape (N, A, A), int32
    bootstrap : Bootstrap
    """
    units = _Units(truth, clip, n_activities)
    weights = clip_resamples(units.activity, n_resamples, np.random.default_rng(seed))
    f1, confusion = [], []
    if block is None:
        block = max(1, COUNT_BYTES // (len(units.size) * n_activities * np.dtype(np.float32).itemsize))

    def counted() -> Iterator[ClipCounts]:
        for first in range(0, predictions.shape[1], block):
            counts = _count(predictions[:, first : first + block], units)
            f1.append(f1_scores(counts, np.ones((1, len(counts.size))))[0])
            confusion.append(counts.confusion())
            yield counts

    share = np.ones(n_activities) if activity_weights is None else activity_weights
    bootstrap = _bootstrap(counted(), weights, level, share)
    return np.concatenate(f1), np.concatenate(confusion), bootstrap


class _Units:
    """What counts as one clip: the windows of one clip and activity."""

    def __init__(self, truth: np.ndarray, clip: np.ndarray, n_activities: int) -> None:
        _, clip_index = np.unique(np.asarray(clip), return_inverse=True)
        units, self.of_window = np.unique(clip_index * n_activities + truth, return_inverse=True)
        self.activity = units % n_activities
        self.n_activities = n_activities
        self.size = np.bincount(self.of_window, minlength=len(units)).astype(np.float32)


def _count(predictions: np.ndarray, units: _Units) -> ClipCounts:
    n_sensors = predictions.shape[1]
    named = np.zeros((len(units.size), n_sensors, units.n_activities), dtype=np.float32)
    cells, first = len(units.size) * units.n_activities, units.of_window * units.n_activities
    for sensor in range(n_sensors):
        found = np.bincount(first + predictions[:, sensor], minlength=cells)
        named[:, sensor] = found.reshape(-1, units.n_activities)
    hit = named[np.arange(len(named)), :, units.activity]
    return ClipCounts(hit, named, units.size, units.activity)


def f1_scores(counts: ClipCounts, weights: np.ndarray) -> np.ndarray:
    """F1 by sensor and activity when each clip counts as often as its weight says.

    Parameters
    ----------
    counts : ClipCounts
    weights : ndarray, shape (B, C)

    Returns
    -------
    ndarray, shape (B, N, A), float32
        2 tp / (2 tp + fp + fn) = 2 tp / (times named + times true); NaN where the
        activity is neither true nor named.
    """
    n_clips, n_sensors, n_activities = counts.named.shape
    weights = np.asarray(weights, dtype=np.float32).T
    # samples of one score lie side by side and are changed in place: half the time
    named = (counts.named.reshape(n_clips, -1).T @ weights).reshape(n_sensors, n_activities, -1)
    scores = np.empty_like(named)
    for activity in range(n_activities):
        of = counts.activity == activity
        named[:, activity] += counts.size[of] @ weights[of]
        scores[:, activity] = 2 * (counts.hit[of].T @ weights[of])
    with np.errstate(invalid="ignore"):
        scores /= named
    return np.moveaxis(scores, 2, 0)


def clip_resamples(activity: np.ndarray, n_resamples: int, rng: np.random.Generator) -> np.ndarray:
    """How often each clip is drawn when as many clips as there are of each activity are drawn
    from them with replacement.

    Parameters
    ----------
    activity : ndarray, shape (C,)
    n_resamples : int
    rng : numpy.random.Generator

    Returns
    -------
    ndarray, shape (n_resamples, C), float32
    """
    weights = np.zeros((n_resamples, len(activity)), dtype=np.float32)
    for label in np.unique(activity):
        members = np.flatnonzero(activity == label)
        chances = np.full(len(members), 1 / len(members))
        weights[:, members] = rng.multinomial(len(members), chances, size=n_resamples)
    return weights


def _bootstrap(
    blocks: Iterable[ClipCounts], weights: np.ndarray, level: float, share: np.ndarray
) -> Bootstrap:
    """Intervals from resamples' weights, over blocks of patches."""
    tail = [(1 - level) / 2, (1 + level) / 2]
    f1_bounds, means = [], []
    for counts in blocks:
        scores = f1_scores(counts, weights)
        means.append(mean_over(scores, share))
        f1_bounds.append(np.quantile(scores, tail, axis=0, overwrite_input=True).astype(np.float32))
    means = np.concatenate(means, axis=1)
    ranks = rankdata(-means, axis=1, method="min")
    f1_low, f1_high = np.concatenate(f1_bounds, axis=1)
    mean_low, mean_high = np.quantile(means, tail, axis=0).astype(np.float32)
    rank_low, rank_high = np.quantile(ranks, tail, axis=0, method="nearest").astype(np.int32)
    return Bootstrap(f1_low, f1_high, mean_low, mean_high, rank_low, rank_high, means)
