# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of predictions: F1 with its uncertainty (a bootstrap over clips), ROC areas, and sums of trials."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, Self

import numpy as np

from ..threads import Spread, chunks, for_each
from ..windows.inputs import PatchBlocks, SomePatches
from .halves import Predictions, TrialPlan
from .weights import mean_over

FEWEST_CLIPS = 5
"""With fewer clips the bootstrap draws nearly the same ones each time, and its interval means nothing."""

COUNT_BYTES = 12 * 2**20
"""Memory for the counts of a block of patches: 20 patches with 5,000 clips and 30 activities. With larger
blocks the samples outgrow the processor's cache."""

SAMPLE_BYTES = 12 * 2**20
"""Memory of a thread for the sums of resamples: 65 patches with 1,000 resamples and 24 activities."""

CLIPS_AT_ONCE = 8192
"""Clips whose counts are weighted at once, in single precision, which takes four times the draws' memory."""

RESAMPLES_AT_ONCE = 64
"""Resamples drawn at once: NumPy draws them as 64-bit numbers."""

COMPARED_AT_ONCE = 256
"""Windows compared with all others at once, so that memory does not grow with their square."""


def f1_of(correct: np.ndarray, predicted: np.ndarray, actual: np.ndarray) -> np.ndarray:
    """F1 = 2 TP / (2 TP + FP + FN), from counts (or weights) of true positives, predicted and actual windows.

    NaN for an activity without actual windows.
    """
    with np.errstate(invalid="ignore"):
        return np.where(actual > 0, 2 * correct / (predicted + actual), np.nan)


def window_f1(predicted: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """F1 of each activity, shape (A,), from the predicted and the actual labels of windows, both (V,)."""
    return f1_of(*window_counts(predicted, labels, n_activities))


def window_counts(predicted: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """True positives, predicted and actual windows of each activity, shape (3, A)."""
    counted = (labels[predicted == labels], predicted, labels)
    return np.stack([np.bincount(activity, minlength=n_activities) for activity in counted])


def confusion_of(truth: np.ndarray, predictions: np.ndarray, n_activities: int) -> np.ndarray:
    """Windows by sensor, actual (W,) and predicted (W, N) activity, shape (N, A, A), int32."""
    cells = [
        np.bincount(truth.astype(np.int64) * n_activities + predicted, minlength=n_activities**2)
        for predicted in predictions.T
    ]
    return np.reshape(cells, (-1, n_activities, n_activities)).astype(np.int32)


@dataclass(frozen=True, eq=False)
class ClipCounts:
    """Counts of C clips by N sensors, from which F1 of a resample is one matrix product."""

    correct: np.ndarray  # (C, N), float32: windows of the clip that the sensor predicts correctly
    predicted: np.ndarray  # (C, N, A), float32: windows of the clip predicted as each activity
    size: np.ndarray  # (C,), float32: windows of the clip
    activity: np.ndarray  # (C,), int


class ClipUnits:
    """Windows (W,) by clip; a clip with several activities counts once for each."""

    def __init__(self, truth: np.ndarray, clip: np.ndarray, n_activities: int) -> None:
        _, clip_index = np.unique(np.asarray(clip), return_inverse=True)
        units, self.of_window = np.unique(clip_index * n_activities + truth, return_inverse=True)
        self.activity = units % n_activities
        self.n_activities = n_activities
        self.size = np.bincount(self.of_window, minlength=len(units)).astype(np.float32)

    def some(self, first: int, last: int) -> tuple[Self, np.ndarray]:
        """The clips from number `first` to before `last`, and the numbers of their windows."""
        windows = np.flatnonzero((self.of_window >= first) & (self.of_window < last))
        clips = self.of_window[windows]
        return type(self)(self.activity[clips], clips, self.n_activities), windows

    def count(self, predictions: np.ndarray) -> ClipCounts:
        """Count true positives and predictions clip by clip, from the predictions (W, N) of N sensors."""
        n_sensors = predictions.shape[1]
        predicted = np.zeros((len(self.size), n_sensors, self.n_activities), dtype=np.float32)
        cells, first = len(self.size) * self.n_activities, self.of_window * self.n_activities
        for sensor in range(n_sensors):
            counts = np.bincount(first + predictions[:, sensor], minlength=cells)
            predicted[:, sensor] = counts.reshape(-1, self.n_activities)
        correct = predicted[np.arange(len(predicted)), :, self.activity]
        return ClipCounts(correct, predicted, self.size, self.activity)


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
) -> tuple[np.ndarray, Bootstrap]:
    """F1 (N, A), float32, of every patch, and its intervals.

    The intervals, of confidence `level`, are those of a percentile bootstrap over clips, within activities
    (Efron and Tibshirani 1993, chapter 13). The models are not trained again: what varies is which clips
    are tested, so the intervals say how far the result depends on the clips at hand, not on the draw of the
    folds. All patches see the same resamples.

    `truth` (W,), `predictions` (W, N) and `clip` (W,) are as for `ClipUnits`; `activity_weights` (A,) say
    what each activity counts in the macro F1, 1 each by default. Counts are integers, so the block sizes do
    not change the result.
    """
    units = ClipUnits(truth, clip, n_activities)
    weights = clip_resamples(units.activity, n_resamples, np.random.default_rng(seed))
    sample_bytes = 2 * n_activities * n_resamples * np.dtype(np.float32).itemsize
    share = np.ones(n_activities) if activity_weights is None else activity_weights
    tail = [(1 - level) / 2, (1 + level) / 2]

    def scored(some: slice) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        scores = _resampled_f1(units, weights, predictions[:, some])
        whole, drawn = scores[0].copy(), scores[1:]
        means = mean_over(drawn, share)
        return whole, means, np.quantile(drawn, tail, axis=0, overwrite_input=True).astype(np.float32)

    blocks = chunks(predictions.shape[1], max(1, SAMPLE_BYTES // sample_bytes))
    f1, means, bounds = zip(*for_each(scored, blocks), strict=True)
    samples = np.concatenate(means, axis=1)
    ranks = np.stack([1 + np.searchsorted(np.sort(row), row) for row in -samples])
    f1_low, f1_high = np.concatenate(bounds, axis=1)
    mean_low, mean_high = np.quantile(samples, tail, axis=0).astype(np.float32)
    rank_low, rank_high = np.quantile(ranks, tail, axis=0, method="nearest").astype(np.int32)
    return np.concatenate(f1), Bootstrap(f1_low, f1_high, mean_low, mean_high, rank_low, rank_high, samples)


def _resampled_f1(units: ClipUnits, weights: np.ndarray, predictions: np.ndarray) -> np.ndarray:
    """F1 (1 + B, N, A) of `predictions` (W, N), of each clip once, then as often as `weights` (B, C) say.

    Adds up some clips at a time.
    """
    (n_resamples, n_clips), n_patches, n_activities = weights.shape, predictions.shape[1], units.n_activities
    correct, predicted = np.zeros((2, n_patches, n_activities, 1 + n_resamples), dtype=np.float32)
    actual = np.zeros((n_activities, 1 + n_resamples), dtype=np.float32)
    clip_bytes = n_activities * np.dtype(np.float32).itemsize
    block = max(1, COUNT_BYTES // (min(n_clips, CLIPS_AT_ONCE) * clip_bytes))
    for start in range(0, n_clips, CLIPS_AT_ONCE):
        some, windows = units.some(start, start + CLIPS_AT_ONCE)
        drawn = np.insert(weights[:, start : start + CLIPS_AT_ONCE], 0, 1, axis=0).T.astype(np.float32)
        some_predictions = predictions[windows]
        for first in range(0, n_patches, block):
            patches = slice(first, first + block)
            sums = _drawn_counts(some.count(some_predictions[:, patches]), drawn)
            correct[patches] += sums[0]
            predicted[patches] += sums[1]
        actual += sums[2]
    return np.moveaxis(f1_of(correct, predicted, actual), 2, 0)


def _drawn_counts(counts: ClipCounts, drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """True positives, predicted (N, A, B) and actual windows (A, B), each clip as often as `drawn` (C, B)."""
    n_clips, n_sensors, n_activities = counts.predicted.shape
    # samples of one score lie side by side, an activity at a time: half the time
    predicted = (counts.predicted.reshape(n_clips, -1).T @ drawn).reshape(n_sensors, n_activities, -1)
    correct, actual = np.zeros_like(predicted), np.zeros(predicted.shape[1:], dtype=predicted.dtype)
    for activity in np.unique(counts.activity):
        clips = np.flatnonzero(counts.activity == activity)
        correct[:, activity] = counts.correct[clips].T @ drawn[clips]
        actual[activity] = counts.size[clips] @ drawn[clips]
    return correct, predicted, actual


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

    Compares all pairs; five times as fast as sorting each line.
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
"""Patches of one task elsewhere, such as on a cluster."""


class TrialScores(NamedTuple):
    """Results of the trials of a plan for N patches."""

    predictions: np.ndarray  # (W_test, N), int16: activities that the whole predicts
    f1: np.ndarray  # (trials, A, N): F1 by window; NaN where an activity was not tested


WHOLE = 0
"""Number of the trial on all clips, the first of a plan."""


def try_patches(
    model: Any,
    source: PatchBlocks,
    planned: TrialPlan,
    alpha: float,
    span: tuple[int, int],
    progress: Callable[[float], None] | None = None,
) -> TrialScores:
    """Run the trials of a plan on the patches of `source` from the first of a span to before its last.

    `alpha` is the ridge of a model with `predict_splits`, as `Ridge` has; `progress` is given the fraction
    done.
    """
    labels, plan, some = planned.labels, planned.plan, SomePatches(source, np.arange(*span))
    position = np.cumsum(planned.is_test) - 1
    trials_of = [
        [number for number, each in enumerate(plan.trials) if split in each.splits]
        for split in range(len(plan.splits))
    ]
    n_patches, n_trials, n_activities = some.shape[1], len(plan.trials), len(plan.whole.testable)
    predictions = np.empty((int(planned.is_test.sum()), n_patches), dtype=np.int16)
    counts = np.zeros((n_patches, n_trials, 3, n_activities), dtype=np.int64)

    def receive(patch: int, predictions_of_patch: Iterable[Predictions]) -> None:
        for split, windows, activities in predictions_of_patch:
            counts[patch, trials_of[split]] += window_counts(activities[0], labels[windows], n_activities)
            if WHOLE in trials_of[split]:
                predictions[position[windows], patch] = activities[0]

    model.predict_splits(some, labels, plan.block, plan.splits, alpha, receive, progress)
    return TrialScores(predictions, np.moveaxis(f1_of(*np.moveaxis(counts, -2, 0)), 0, 2))


def try_all(
    model: Any,
    source: PatchBlocks,
    planned: TrialPlan,
    progress: Callable[[float], None] | None,
    spread: Spread | None,
) -> TrialScores:
    """Run the trials of a plan on all patches of `source`; a `spread` runs some at a time elsewhere."""
    n_patches = source.shape[1]
    spread = spread if n_patches > TASK_PATCHES else None
    alpha = model.choose_alpha(source, planned.labels, planned.fold, planned.is_test, spread)
    if spread is None:
        return try_patches(model, source, planned, alpha, (0, n_patches), progress)
    spans = [(first, min(first + TASK_PATCHES, n_patches)) for first in range(0, n_patches, TASK_PATCHES)]
    parts = []
    for tried in spread(partial(try_patches, replace(model, workers=1), source, planned, alpha), spans):
        parts.append(tried)
        if progress is not None:
            progress(len(parts) / len(spans))
    return TrialScores(*(np.concatenate(values, axis=-1) for values in zip(*parts, strict=True)))
