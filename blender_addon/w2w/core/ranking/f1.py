# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of predictions: F1 with its uncertainty (a bootstrap over clips), ROC areas, and sums of trials."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
import scipy

from ..windows.inputs import PatchBlocks, SomePatches
from .halves import Named, Planned
from .weights import mean_over

FEWEST_CLIPS = 5
"""From fewer clips the bootstrap draws nearly the same ones each time, and its interval means nothing."""

COUNT_BYTES = 12 * 2**20
"""Memory for the counts of the patches looked at at a time: of 5,000 clips and 30 activities 20 patches'.
Of more at a time the samples outgrow the processor's cache."""

SAMPLE_BYTES = 12 * 2**20
"""Memory for the sums of resamples: of 1,000 resamples and 24 activities those of 65 patches."""

CLIPS_AT_ONCE = 8192
"""Clips whose counts are weighted at once, in single precision: it takes four times what the draws do."""

RESAMPLES_AT_ONCE = 64
"""Resamples drawn at once: NumPy draws them as 64-bit numbers."""

COMPARED_AT_ONCE = 256
"""Windows that are compared with all others at once, so that memory does not grow with their square."""


def f1_of(hit: np.ndarray, named: np.ndarray, true: np.ndarray) -> np.ndarray:
    """2 tp / (2 tp + fp + fn) from windows named rightly, named so and truly so, counted or weighted.

    NaN where no window is truly so.
    """
    with np.errstate(invalid="ignore"):
        return np.where(true > 0, 2 * hit / (named + true), np.nan)


def window_f1(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """F1 of each activity, shape (A,), from the names given to windows (V,) and their true labels (V,)."""
    return f1_of(*window_counts(named, labels, n_activities))


def window_counts(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """Windows named rightly, named so and truly so, of each activity, shape (3, A)."""
    hit = np.bincount(labels[named == labels], minlength=n_activities)
    return np.stack([hit, *(np.bincount(of, minlength=n_activities) for of in (named, labels))])


@dataclass(frozen=True, eq=False)
class ClipCounts:
    """Counts of C clips as N sensors named them, from which F1 of a resample is one matrix product."""

    hit: np.ndarray  # (C, N), float32: windows of the clip that the sensor named rightly
    named: np.ndarray  # (C, N, A), float32: windows that it named so, rightly or not
    size: np.ndarray  # (C,), float32: windows of the clip
    activity: np.ndarray  # (C,), int

    def confusion(self) -> np.ndarray:
        """Windows by sensor, true and named activity, shape (N, A, A), int32."""
        n_activities = self.named.shape[2]
        of = [self.named[self.activity == a].sum(axis=0) for a in range(n_activities)]
        return np.stack(of, axis=1).astype(np.int32)


class ClipUnits:
    """Windows (W,) by clip; those of one clip and several activities count as several clips."""

    def __init__(self, truth: np.ndarray, clip: np.ndarray, n_activities: int) -> None:
        _, clip_index = np.unique(np.asarray(clip), return_inverse=True)
        units, self.of_window = np.unique(clip_index * n_activities + truth, return_inverse=True)
        self.activity = units % n_activities
        self.n_activities = n_activities
        self.size = np.bincount(self.of_window, minlength=len(units)).astype(np.float32)

    def some(self, first: int, last: int) -> tuple[Self, np.ndarray]:
        """Clips from the number `first` to before `last` by themselves, and their windows by number."""
        windows = np.flatnonzero((self.of_window >= first) & (self.of_window < last))
        clips = self.of_window[windows]
        return type(self)(self.activity[clips], clips, self.n_activities), windows

    def count(self, predictions: np.ndarray) -> ClipCounts:
        """Count hits and names clip by clip, of the activities that N sensors name, (W, N)."""
        n_sensors = predictions.shape[1]
        named = np.zeros((len(self.size), n_sensors, self.n_activities), dtype=np.float32)
        cells, first = len(self.size) * self.n_activities, self.of_window * self.n_activities
        for sensor in range(n_sensors):
            found = np.bincount(first + predictions[:, sensor], minlength=cells)
            named[:, sensor] = found.reshape(-1, self.n_activities)
        hit = named[np.arange(len(named)), :, self.activity]
        return ClipCounts(hit, named, self.size, self.activity)


class Bootstrap(NamedTuple):
    """Percentile intervals, and the macro F1 of every resample."""

    f1_low: np.ndarray  # (N, A)
    f1_high: np.ndarray
    mean_low: np.ndarray  # (N,): of macro F1
    mean_high: np.ndarray
    rank_low: np.ndarray  # (N,): of the rank by macro F1; 1 is the best
    rank_high: np.ndarray
    mean_samples: np.ndarray  # (B, N)


def score_patches(
    truth: np.ndarray,
    predictions: np.ndarray,
    clip: np.ndarray,
    n_activities: int,
    n_resamples: int,
    level: float,
    seed: int,
    activity_weights: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, Bootstrap]:
    """F1 (N, A), float32, and confusion (N, A, A), int32, of every patch, and how sure they are.

    The intervals, of confidence `level`, are those of a percentile bootstrap over clips, within activities
    (Efron and Tibshirani 1993, chapter 13). The models are not trained again: what varies is which clips
    are tested, so the intervals say how far the result depends on the clips at hand, not on the draw of the
    folds. All patches see the same resamples.

    `truth` (W,), `predictions` (W, N) and `clip` (W,) are as for `ClipUnits`; `activity_weights` (A,) say
    what each activity counts in the macro F1, all alike by default. Counts are whole numbers: how many clips
    and patches are looked at at a time changes no bit.
    """
    units = ClipUnits(truth, clip, n_activities)
    weights = clip_resamples(units.activity, n_resamples, np.random.default_rng(seed))
    block = max(1, SAMPLE_BYTES // (2 * n_activities * n_resamples * np.dtype(np.float32).itemsize))
    share = np.ones(n_activities) if activity_weights is None else activity_weights
    tail = [(1 - level) / 2, (1 + level) / 2]
    confusion, means, bounds = [], [], []
    for first in range(0, predictions.shape[1], block):
        drawn = _resampled(units, weights, predictions[:, first : first + block])
        confusion.append(drawn.confusion)
        scores = np.moveaxis(f1_of(drawn.hit, drawn.named, drawn.true), 2, 0)
        means.append(mean_over(scores, share))
        bounds.append(np.quantile(scores, tail, axis=0, overwrite_input=True).astype(np.float32))
    samples = np.concatenate(means, axis=1)
    ranks = scipy.stats.rankdata(-samples, axis=1, method="min")
    f1_low, f1_high = np.concatenate(bounds, axis=1)
    mean_low, mean_high = np.quantile(samples, tail, axis=0).astype(np.float32)
    rank_low, rank_high = np.quantile(ranks, tail, axis=0, method="nearest").astype(np.int32)
    bootstrap = Bootstrap(f1_low, f1_high, mean_low, mean_high, rank_low, rank_high, samples)
    whole = np.concatenate(confusion)
    counted = whole.astype(np.float32)
    f1 = f1_of(np.einsum("naa->na", counted), counted.sum(axis=1), counted.sum(axis=2))
    return f1, whole, bootstrap


class _Resampled(NamedTuple):
    """Windows of N sensors, A activities and B resamples."""

    confusion: np.ndarray  # (N, A, A), int32: of all clips, each once
    hit: np.ndarray  # (N, A, B), float32: named rightly
    named: np.ndarray  # (N, A, B), float32: named so
    true: np.ndarray  # (A, B), float32


def _resampled(units: ClipUnits, weights: np.ndarray, predictions: np.ndarray) -> _Resampled:
    """Sums of `predictions` (W, N) with each clip as often as `weights` (B, C) say, some clips at a time."""
    (n_resamples, n_clips), n_patches, n_activities = weights.shape, predictions.shape[1], units.n_activities
    confusion = np.zeros((n_patches, n_activities, n_activities), dtype=np.int32)
    hit, named = np.zeros((2, n_patches, n_activities, n_resamples), dtype=np.float32)
    true = np.zeros((n_activities, n_resamples), dtype=np.float32)
    clip_bytes = n_activities * np.dtype(np.float32).itemsize
    block = max(1, COUNT_BYTES // (min(n_clips, CLIPS_AT_ONCE) * clip_bytes))
    for start in range(0, n_clips, CLIPS_AT_ONCE):
        some, windows = units.some(start, start + CLIPS_AT_ONCE)
        drawn = weights[:, start : start + CLIPS_AT_ONCE].T.astype(np.float32)
        names = predictions[windows]
        for first in range(0, n_patches, block):
            these = slice(first, first + block)
            counts = some.count(names[:, these])
            confusion[these] += counts.confusion()
            right, said, truly = _drawn_counts(counts, drawn)
            hit[these] += right
            named[these] += said
        true += truly
    return _Resampled(confusion, hit, named, true)


def _drawn_counts(counts: ClipCounts, drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Windows named rightly, named so (N, A, B) and truly so (A, B), each clip as often as `drawn` (C, B)."""
    n_clips, n_sensors, n_activities = counts.named.shape
    # samples of one score lie side by side, an activity at a time: half the time
    named = (counts.named.reshape(n_clips, -1).T @ drawn).reshape(n_sensors, n_activities, -1)
    hit, true = np.zeros_like(named), np.zeros(named.shape[1:], dtype=named.dtype)
    for activity in np.unique(counts.activity):
        of = np.flatnonzero(counts.activity == activity)
        hit[:, activity] = counts.hit[of].T @ drawn[of]
        true[activity] = counts.size[of] @ drawn[of]
    return hit, named, true


def f1_scores(counts: ClipCounts, weights: np.ndarray) -> np.ndarray:
    """F1 by sensor and activity, shape (B, N, A), float32, each clip counting as `weights` (B, C) say."""
    return np.moveaxis(f1_of(*_drawn_counts(counts, weights.T.astype(np.float32))), 2, 0)


def clip_resamples(activity: np.ndarray, n_resamples: int, rng: np.random.Generator) -> np.ndarray:
    """Number of times that each clip, of activities (C,), is drawn, shape (n_resamples, C), uint8.

    From the clips of each activity as many are drawn, with replacement.
    """
    weights = np.zeros((n_resamples, len(activity)), dtype=np.uint8)
    for label in np.unique(activity):
        members = np.flatnonzero(activity == label)
        chances = np.full(len(members), 1 / len(members))
        for start in range(0, n_resamples, RESAMPLES_AT_ONCE):
            some = weights[start : start + RESAMPLES_AT_ONCE]
            some[:, members] = rng.multinomial(len(members), chances, size=len(some))
    return weights


def class_auc(scores: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Area under the ROC curve of each activity against all others, shape (A,); NaN without windows of it.

    `scores` (V, A) are compared between windows, about their means over activities, in single precision;
    `labels` (V,) are the true activities, `weight` (V,) is what each window counts.
    """
    present, line = np.unique(labels, return_inverse=True)
    lines = np.ascontiguousarray(scores[:, present].T, dtype=np.float32)
    known = np.isfinite(lines)
    sums, counts = (part.sum(axis=0) for part in (np.where(known, lines, 0), known))
    below = _others_below(lines - (sums / counts).astype(np.float32), line)
    areas = np.full(scores.shape[1], np.nan)
    votes = np.bincount(line, below * weight)
    size, vote = np.bincount(line), np.bincount(line, weight)
    areas[present] = votes / vote / np.maximum(len(labels) - size, 1)
    return areas


def _others_below(scores: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Windows of other activities that score below each window on the line (A, V) of its own, shape (V,).

    Each is compared with each: a fifth of the time of sorting all lines.
    """
    windows = np.arange(len(line))
    own = scores[line, windows]
    others = scores.copy()
    others[line, windows] = np.inf
    below = np.empty(len(line), dtype=np.int64)
    for first in range(0, len(line), COMPARED_AT_ONCE):
        rows = slice(first, first + COMPARED_AT_ONCE)
        is_below = others[line[rows]] < own[rows, None]
        below[rows] = is_below.view(np.int8).sum(axis=1, dtype=np.int32)  # half the time of count_nonzero
    return below


TASK_PATCHES = 16
"""Patches that are tried in one piece elsewhere."""


class Tried(NamedTuple):
    """Results of the trials of a plan for N patches."""

    predictions: np.ndarray  # (W_test, N), int16: activities that the whole named
    f1: np.ndarray  # (trials, A, N): F1 by window; NaN where an activity was not tested


WHOLE = 0
"""Number of the trial on all clips, the first of a plan."""

Spread = Callable[[Callable[[tuple[int, int]], Tried], Sequence[tuple[int, int]]], Iterable[Tried]]
"""Calls a function with each of some items, wherever, and gives the results in their order: as `map` does."""


def try_patches(
    model: Any,
    source: PatchBlocks,
    trial: Planned,
    alpha: float,
    span: tuple[int, int],
    progress: Callable[[float], None] | None = None,
) -> Tried:
    """Try the patches of `source` from the first of a span to before its last.

    By the ridge `alpha` of a model with `name_splits`, as `Ridge` has; `progress` is given the fraction done.
    """
    labels, plan, some = trial.labels, trial.plan, SomePatches(source, *span)
    position = np.cumsum(trial.is_test) - 1
    trials_of = [
        [number for number, one in enumerate(plan.trials) if split in one.splits]
        for split in range(len(plan.splits))
    ]
    n_patches, n_trials, n_activities = some.shape[1], len(plan.trials), len(plan.whole.testable)
    predictions = np.empty((int(trial.is_test.sum()), n_patches), dtype=np.int16)
    counts = np.zeros((n_patches, n_trials, 3, n_activities), dtype=np.int64)

    def receive(patch: int, found: Iterable[Named]) -> None:
        for split, windows, activities in found:
            counts[patch, trials_of[split]] += window_counts(activities[0], labels[windows], n_activities)
            if WHOLE in trials_of[split]:
                predictions[position[windows], patch] = activities[0]

    model.name_splits(some, labels, plan.block, plan.splits, alpha, receive, progress)
    return Tried(predictions, np.moveaxis(f1_of(*np.moveaxis(counts, -2, 0)), 0, 2))
