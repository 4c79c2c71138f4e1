# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of a patch from how a classifier orders the activities: steadier than F1 from the first alone.

Counting first names only, a window that is nearly right counts as one that is far off, so that few windows
decide a map.
"""

from __future__ import annotations

import numpy as np


def rank_score(scores: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Mean of an F1 that takes in the whole order and of the share of other activities outscored.

    In the F1 each window names every activity, in shares by the reciprocal of its rank (Voorhees
    1999, TREC-8): it tells patches apart where most windows are right, the share where most are wrong.

    Parameters
    ----------
    scores : ndarray, shape (V, A)
        Of each activity by window; of higher ones more.
    labels : ndarray of int, shape (V,)
        True activity.
    weight : ndarray, shape (V,)
        What each window counts.

    Returns
    -------
    ndarray, shape (A,)
        NaN for activities without windows. 1 is out of reach: a perfect order gives the true one
        its share of first place.
    """
    n_activities = scores.shape[1]
    rank = (-scores).argsort(axis=1, kind="stable").argsort(axis=1)
    of_true = rank[np.arange(len(labels)), labels]
    share = weight[:, None] / (1.0 + rank) / (1.0 / np.arange(1, n_activities + 1)).sum()
    true = np.bincount(labels, weights=weight, minlength=n_activities)
    hit = np.bincount(labels, weights=share[np.arange(len(labels)), labels], minlength=n_activities)
    outscored = weight * (1.0 - of_true / max(n_activities - 1, 1))
    with np.errstate(invalid="ignore"):
        beaten = np.bincount(labels, weights=outscored, minlength=n_activities) / true
    return (_f1(hit, share.sum(axis=0), true) + beaten) / 2


def class_auc(scores: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Area under the ROC curve of each activity against all others.

    Parameters
    ----------
    scores : ndarray, shape (..., V, A)
        As for `rank_score`, of any number of classifiers; compared between windows, about their means
        over activities, in single precision.
    labels, weight
        As for `rank_score`.

    Returns
    -------
    ndarray, shape (..., A)
        NaN for activities without windows.
    """
    return _areas(scores, np.unique(labels), labels, weight)


def _areas(scores: np.ndarray, compared: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """As `class_auc`, the scores about their means over the activities `compared`."""
    *many, n_windows, n_activities = scores.shape
    about = _about_their_means(scores[..., compared].reshape(-1, n_windows, len(compared)))
    present, line = np.unique(labels, return_inverse=True)
    about = about[:, np.isin(compared, present)]
    lines = np.arange(about.shape[0] * len(present)).reshape(-1, len(present), 1)
    everyone = _keys(np.sort(about, axis=2), lines).ravel()
    own = _keys(about[:, line, np.arange(n_windows)], lines[:, line, 0])
    order = own.argsort(axis=1)  # activity by activity
    own = np.take_along_axis(own, order, axis=1)
    size = np.bincount(line)
    start = np.cumsum(size) - size
    before = np.arange(n_windows)  # of the same activity; equal ones are not below each other
    before = np.maximum.accumulate(np.where(np.diff(own, prepend=own[:, :1] - 1) > 0, before, 0), axis=1)
    line = np.repeat(np.arange(len(present)), size)
    below = np.searchsorted(everyone, own) - lines[:, line, 0] * n_windows - (before - start[line])
    areas = np.full((len(about), n_activities), np.nan)
    vote = weight[order]
    votes = np.add.reduceat(below * vote, start, axis=1) / np.add.reduceat(vote, start, axis=1)
    areas[:, present] = votes / np.maximum(n_windows - size, 1)
    return areas.reshape(*many, n_activities)


def class_auc_at_most(scores: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """What `class_auc` cannot exceed, by scores of the first windows alone.

    Two windows that are in the wrong order stay so whatever the others' scores are.

    Parameters
    ----------
    scores : ndarray, shape (..., v, A)
        Of the first v of the windows.
    labels, weight : ndarray, shape (V,)
        Of all windows.

    Returns
    -------
    ndarray, shape (..., A)
    """
    seen = scores.shape[-2]
    lost = np.nan_to_num(1.0 - _areas(scores, np.unique(labels), labels[:seen], weight[:seen]))
    for share in _votes_and_others(labels[:seen], weight[:seen], scores.shape[-1]):
        lost *= share
    for whole in _votes_and_others(labels, weight, scores.shape[-1]):
        lost /= np.maximum(whole, np.finfo(float).tiny)
    return 1.0 - lost


def _votes_and_others(
    labels: np.ndarray, weight: np.ndarray, n_activities: int
) -> tuple[np.ndarray, np.ndarray]:
    """Of each activity, the weight of its windows and the number of all other windows, shape (A,) each."""
    of_each = np.bincount(labels, minlength=n_activities)
    return np.bincount(labels, weights=weight, minlength=n_activities), len(labels) - of_each


def _about_their_means(scores: np.ndarray) -> np.ndarray:
    """Scores (P, V, A) about each window's mean over the activities that were trained, shape (P, A, V)."""
    scores = np.ascontiguousarray(scores.swapaxes(1, 2), dtype=np.float32)
    known = np.isfinite(scores)
    if known.all():
        return scores - scores.mean(axis=1, keepdims=True)
    sums, counts = (part.sum(axis=1, keepdims=True) for part in (np.where(known, scores, 0), known))
    return scores - (sums / counts).astype(np.float32)


def _keys(values: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Integers in the order of lines and, within a line, of values in single precision."""
    bits = values.view(np.int32)
    return (bits ^ ((bits >> 31) & np.int32(0x7FFFFFFF))) + (line.astype(np.int64) << 33)


def window_f1(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """F1 of each activity from the names given to windows, shape (A,); NaN for those without windows."""
    true = np.bincount(labels, minlength=n_activities)
    hit = np.bincount(labels[named == labels], minlength=n_activities)
    return _f1(hit, np.bincount(named, minlength=n_activities), true)


def _f1(hit: np.ndarray, named: np.ndarray, true: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.where(true > 0, 2 * hit / (named + true), np.nan)
