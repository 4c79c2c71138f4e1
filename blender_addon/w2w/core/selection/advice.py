# SPDX-License-Identifier: GPL-3.0-or-later
"""What a ranking means for a designer: the best spot, the sensors to wear together, what says the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap
from .constraints import Constraints
from .joint import JointSet, choose_together
from .set_tests import SetTests
from .terms import Terms, open_mask


def prediction_correlation(predictions: np.ndarray, n_activities: int) -> np.ndarray:
    """Correlation between the predictions of every two patches.

    Gorodkin's R_K (2004, doi:10.1016/j.compbiolchem.2004.09.006), the correlation
    coefficient of two classifications: 1 where two patches always name the same activity,
    rightly or wrongly, and 0 where they agree no more than chance would have it.

    Parameters
    ----------
    predictions : ndarray of int, shape (W, N)
        As in `UtilityMap.predictions`.
    n_activities : int

    Returns
    -------
    ndarray, shape (N, N), float64
        A patch that always names one activity correlates 0 with all others.
    """
    n_windows, n_patches = predictions.shape
    parts = [predictions[first : first + WINDOWS_AT_ONCE] for first in range(0, n_windows, WINDOWS_AT_ONCE)]
    covariance = np.zeros((n_patches, n_patches))
    for activity in range(n_activities):
        mean = sum((part == activity).sum(axis=0) for part in parts) / n_windows
        for part in parts:
            named = (part == activity).astype(np.float32) - mean.astype(np.float32)
            covariance += named.T @ named
    variance = np.diag(covariance).copy()
    variance[variance <= 0] = np.inf
    correlation = covariance / np.sqrt(np.outer(variance, variance))
    np.fill_diagonal(correlation, 1.0)
    return correlation


def redundancy_clusters(predictions: np.ndarray, n_activities: int, correlation: float = 0.8) -> np.ndarray:
    """Group patches whose predictions correlate.

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
        Cluster of each patch, 0 the largest.

    Raises
    ------
    ValueError
        If `correlation` is not between 0 and 1.
    """
    if not 0 < correlation <= 1:
        raise ValueError(f"correlation must be in (0, 1], not {correlation}")
    n_patches = predictions.shape[1]
    if n_patches == 1:
        return np.zeros(1, dtype=np.int64)
    distance = np.clip(1.0 - prediction_correlation(predictions, n_activities), 0.0, 2.0)
    np.fill_diagonal(distance, 0.0)
    tree = linkage(squareform(distance, checks=False), method="average")
    cluster = fcluster(tree, 1.0 - correlation + 1e-9, criterion="distance") - 1
    by_size = np.argsort(-np.bincount(cluster), kind="stable")
    return np.argsort(by_size)[cluster]


WINDOWS_AT_ONCE = 4096
"""Windows whose predictions are correlated at once, so that memory does not grow with the library."""

SAME_OPINION = 0.8
"""Mean correlation of predictions from which patches are grouped as saying the same."""


def best_single(utility: UtilityMap, allowed: np.ndarray | None = None) -> int:
    """The allowed patch with the highest expected macro F1; of equals the highest on these clips."""
    open_patches = np.flatnonzero(open_mask(allowed, len(utility.mean)))
    order = np.lexsort((-utility.mean[open_patches], -utility.expected_mean[open_patches]))
    return int(open_patches[order[0]])


@dataclass(frozen=True, eq=False)
class Advice:
    """Where to wear, under a designer's constraints.

    Attributes
    ----------
    best : int
        Allowed patch with the highest expected macro F1.
    worn : JointSet or None
        The patches to wear together; None where nothing tests sets.
    alternatives : tuple of ndarray of int
        For each of these, the other allowed patches of its cluster whose F1 cannot be told from its own.
    clusters : ndarray, shape (N,), int
        Patches of one number say the same; 0 is the largest cluster.
    allowed : ndarray of bool, shape (N,), optional
        Patches that the constraints leave; all by default.
    """

    best: int
    worn: JointSet | None
    alternatives: tuple[np.ndarray, ...]
    clusters: np.ndarray
    allowed: np.ndarray | None = None


def advise(
    utility: UtilityMap,
    patches: PatchSet,
    tests: SetTests | None,
    target: float = 0.9,
    every_activity: float = 0.0,
    max_places: int | None = None,
    constraints: Constraints | None = None,
) -> Advice:
    """Choose patches from a finished ranking.

    Parameters
    ----------
    utility : UtilityMap
    patches : PatchSet
        The patches ranked.
    tests : SetTests or None
        What sets are chosen and judged by; None for the best spot alone.
    target, every_activity : float
        As for `choose_together`.
    max_places : int, optional
        Most patches.
    constraints : Constraints, optional

    Returns
    -------
    Advice

    Raises
    ------
    ValueError
        If the constraints cannot be met.
    """
    terms = Terms.checked(len(patches), max_places, **(constraints or Constraints()).terms(patches))
    worn = None
    if tests is not None:
        worn = choose_together(tests, utility.expected, terms, target, every_activity)
    clusters = redundancy_clusters(utility.predictions, len(utility.activities), SAME_OPINION)
    others = ~np.eye(len(patches), dtype=bool)
    return Advice(
        best=best_single(utility, terms.allowed),
        worn=worn,
        alternatives=tuple(
            np.flatnonzero(
                (clusters == clusters[patch]) & utility.same_as(patch) & terms.allowed & others[patch]
            )
            for patch in (worn.order if worn else ())
        ),
        clusters=clusters,
        allowed=terms.allowed,
    )
