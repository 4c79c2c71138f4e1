# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of a patch from what a classifier says of windows: F1, and the area under the ROC curve."""

from __future__ import annotations

import numpy as np

COMPARED_AT_ONCE = 256
"""Windows that are compared with all others at once, so that memory does not grow with their square."""


def class_auc(scores: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Area under the ROC curve of each activity against all others.

    Parameters
    ----------
    scores : ndarray, shape (V, A)
        Of each activity by window; compared between windows, about their means over activities, in single
        precision.
    labels : ndarray of int, shape (V,)
        True activity.
    weight : ndarray, shape (V,)
        What each window counts.

    Returns
    -------
    ndarray, shape (A,)
        NaN for activities without windows.
    """
    present, line = np.unique(labels, return_inverse=True)
    below = _others_below(_about_their_means(scores[:, present]), line)
    areas = np.full(scores.shape[1], np.nan)
    votes = np.bincount(line, below * weight)
    size, vote = np.bincount(line), np.bincount(line, weight)
    areas[present] = votes / vote / np.maximum(len(labels) - size, 1)
    return areas


def _others_below(scores: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Of each window, how many of other activities score below it on the line (A, V) of its own, shape (V,).

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


def _about_their_means(scores: np.ndarray) -> np.ndarray:
    """Scores (V, A) about each window's mean over the activities that were trained, shape (A, V)."""
    scores = np.ascontiguousarray(scores.T, dtype=np.float32)
    known = np.isfinite(scores)
    if known.all():
        return scores - scores.mean(axis=0)
    sums, counts = (part.sum(axis=0) for part in (np.where(known, scores, 0), known))
    return scores - (sums / counts).astype(np.float32)


def window_f1(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """F1 of each activity from the names given to windows, shape (A,); NaN for those without windows."""
    return f1_of(window_counts(named, labels, n_activities))


def window_counts(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """Windows named rightly, named so and truly so, of each activity, shape (3, A)."""
    hit = np.bincount(labels[named == labels], minlength=n_activities)
    return np.stack([hit, *(np.bincount(of, minlength=n_activities) for of in (named, labels))])


def f1_of(counts: np.ndarray) -> np.ndarray:
    """F1 from hits, names and truths (..., 3, A), counted or weighted, shape (..., A)."""
    hit, named, true = np.moveaxis(counts, -2, 0)
    with np.errstate(invalid="ignore"):
        return np.where(true > 0, 2 * hit / (named + true), np.nan)
