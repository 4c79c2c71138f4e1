# SPDX-License-Identifier: GPL-3.0-or-later
"""Places that say the same thing: correlation of their predictions, and clusters of it."""

from __future__ import annotations

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform


def prediction_correlation(predictions: np.ndarray, n_activities: int) -> np.ndarray:
    """Correlation between the predictions of every two places.

    Gorodkin's R_K (2004, doi:10.1016/j.compbiolchem.2004.09.006), the correlation
    coefficient of two classifications: 1 where two places always name the same activity,
    rightly or wrongly, and 0 where they agree no more than chance would have it.

    Parameters
    ----------
    predictions : ndarray of int, shape (W, N)
        As in `UtilityMap.predictions`.
    n_activities : int

    Returns
    -------
    ndarray, shape (N, N), float64
        A place that always names one activity correlates 0 with all others.
    """
    n_places = predictions.shape[1]
    covariance = np.zeros((n_places, n_places))
    for activity in range(n_activities):
        named = (predictions == activity).astype(np.float32)
        named -= named.mean(axis=0)
        covariance += named.T @ named
    variance = np.diag(covariance).copy()
    variance[variance <= 0] = np.inf
    correlation = covariance / np.sqrt(np.outer(variance, variance))
    np.fill_diagonal(correlation, 1.0)
    return correlation


def redundancy_clusters(predictions: np.ndarray, n_activities: int, correlation: float = 0.8) -> np.ndarray:
    """Group places whose predictions correlate.

    Average linkage: within a cluster the mean correlation between the parts last joined
    is at least `correlation`.

    Parameters
    ----------
    predictions : ndarray of int, shape (W, N)
    n_activities : int
    correlation : float
        Between 0 and 1; higher makes more and smaller clusters.

    Returns
    -------
    ndarray, shape (N,), int
        Cluster of each place, 0 the largest.

    Raises
    ------
    ValueError
        If `correlation` is not between 0 and 1.
    """
    if not 0 < correlation <= 1:
        raise ValueError(f"correlation must be in (0, 1], not {correlation}")
    n_places = predictions.shape[1]
    if n_places == 1:
        return np.zeros(1, dtype=np.int64)
    distance = np.clip(1.0 - prediction_correlation(predictions, n_activities), 0.0, 2.0)
    np.fill_diagonal(distance, 0.0)
    tree = linkage(squareform(distance, checks=False), method="average")
    cluster = fcluster(tree, 1.0 - correlation + 1e-9, criterion="distance") - 1
    by_size = np.argsort(-np.bincount(cluster), kind="stable")
    return np.argsort(by_size)[cluster]
