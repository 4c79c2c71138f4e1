# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 from the order in which a classifier ranks the activities: steadier than F1 from the first alone."""

from __future__ import annotations

import numpy as np


def soft_f1(scores: np.ndarray, labels: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """F1 where each window names every activity, in shares by the reciprocal of its rank.

    Counting first names only, a window that is nearly right counts as one that is far off, so that
    few windows decide a map. The reciprocal rank (Voorhees 1999, TREC-8) takes in the whole order.

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
    share = weight[:, None] / (1.0 + rank)
    share /= (1.0 / np.arange(1, n_activities + 1)).sum()
    true = np.bincount(labels, weights=weight, minlength=n_activities)
    hit = np.bincount(labels, weights=share[np.arange(len(labels)), labels], minlength=n_activities)
    return _f1(hit, share.sum(axis=0), true)


def window_f1(named: np.ndarray, labels: np.ndarray, n_activities: int) -> np.ndarray:
    """F1 of each activity from the names given to windows, shape (A,); NaN for those without windows."""
    true = np.bincount(labels, minlength=n_activities)
    hit = np.bincount(labels[named == labels], minlength=n_activities)
    return _f1(hit, np.bincount(named, minlength=n_activities), true)


def _f1(hit: np.ndarray, named: np.ndarray, true: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.where(true > 0, 2 * hit / (named + true), np.nan)
