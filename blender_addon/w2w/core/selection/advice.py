# SPDX-License-Identifier: GPL-3.0-or-later
"""Advice for a designer: the best spot, the sensors to wear together, equivalent patches."""

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
    """Correlation (N, N), float64, between the predictions (W, N) of every two patches.

    Gorodkin's R_K (2004, doi:10.1016/j.compbiolchem.2004.09.006), the correlation
    coefficient of two classifications: 1 where two patches always name the same activity,
    rightly or wrongly, and 0 where they agree no more than by chance. A patch that always names one activity
    correlates 0 with all others.
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
    """Cluster of each patch, shape (N,), int, 0 the largest, by how its predictions (W, N) correlate.

    Average linkage: within a cluster the mean correlation between the parts last joined
    is at least `correlation`, above 0 and up to 1; higher makes more and smaller clusters.
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
"""Mean correlation of predictions from which patches are grouped as equivalent."""


def best_single(utility: UtilityMap, allowed: np.ndarray | None = None) -> int:
    """The allowed patch with the highest expected macro F1; of equals the highest on these clips."""
    open_patches = np.flatnonzero(open_mask(allowed, len(utility.mean)))
    order = np.lexsort((-utility.mean[open_patches], -utility.expected_mean[open_patches]))
    return int(open_patches[order[0]])


@dataclass(frozen=True, eq=False)
class Advice:
    """Where to wear, under a designer's constraints."""

    best: int  # allowed patch with the highest expected macro F1
    worn: JointSet | None  # the patches to wear together; None where nothing tests sets
    alternatives: tuple[np.ndarray, ...]  # to each of these: allowed patches of its cluster, as good
    clusters: np.ndarray  # (N,), int: as from `redundancy_clusters`
    allowed: np.ndarray | None = None  # (N,), bool: patches that the constraints leave; all by default


def advise(
    utility: UtilityMap,
    patches: PatchSet,
    tests: SetTests | None,
    target: float = 0.9,
    every_activity: float = 0.0,
    max_places: int | None = None,
    constraints: Constraints | None = None,
) -> Advice:
    """Choose patches from a finished ranking: sets by their `tests`, else the best spot alone.

    `target` and `every_activity` are as for `choose_together`. A ValueError says which constraints cannot be
    met.
    """
    terms = Terms.checked(len(patches), max_places, **(constraints or Constraints()).terms(patches))
    worn = choose_together(tests, utility.expected, terms, target, every_activity) if tests else None
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
