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
    scores, labels, weight
        As for `rank_score`; scores are compared between windows, about their means over activities.

    Returns
    -------
    ndarray, shape (A,)
        NaN for activities without windows.
    """
    areas = np.full(scores.shape[1], np.nan)
    present = np.unique(labels)
    known = np.isfinite(scores)  # of the activities that were trained
    level = np.where(known, scores, 0.0)[:, present].sum(axis=1) / known[:, present].sum(axis=1)
    about = scores - level[:, None]
    for activity in present:
        own = labels == activity
        others = np.sort(about[~own, activity])
        below = np.searchsorted(others, about[own, activity]) / max(len(others), 1)
        areas[activity] = np.average(below, weights=weight[own])
    return areas


def window_f1(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """F1 of each activity from the names given to windows, shape (A,); NaN for those without windows."""
    true = np.bincount(labels, minlength=n_activities)
    hit = np.bincount(labels[named == labels], minlength=n_activities)
    return _f1(hit, np.bincount(named, minlength=n_activities), true)


def _f1(hit: np.ndarray, named: np.ndarray, true: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.where(true > 0, 2 * hit / (named + true), np.nan)
