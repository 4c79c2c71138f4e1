# SPDX-License-Identifier: GPL-3.0-or-later
"""What a ranking means for a designer: where to wear, what one sensor more would bring, what is the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap
from .constraints import Constraints
from .subsets import ROUNDING, Subset, best_single, exact_subset, greedy_subset, marginal_gain
from .terms import fewest


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

SOLVER_S = 10.0
"""Seconds that each of the two steps of the exact choice may take."""

SAME_OPINION = 0.8
"""Mean correlation of predictions from which patches are grouped as saying the same."""


@dataclass(frozen=True, eq=False)
class Advice:
    """Where to wear, under a designer's constraints.

    Attributes
    ----------
    best : int
        Allowed patch with the highest expected macro F1.
    subset : Subset
        The paper's greedy choice.
    exact : Subset or None
        The cheapest set that does it; None where the solver found none in time.
    next_patch : int
        The allowed patch that would add most to the greedy set, -1 where nothing is left.
    next_gain : float
        What it would add to the mean-max F1.
    clusters : ndarray, shape (N,), int
        Patches of one number say the same; 0 is the largest cluster.
    alternatives : tuple of ndarray of int
        For each patch of the greedy set, the other allowed patches of its cluster whose F1
        cannot be told from its own.
    least : int
        How many of the greedy set's first patches it takes to have one wherever one must be.
    allowed : ndarray of bool, shape (N,), optional
        Patches that the constraints leave; all by default.
    """

    best: int
    subset: Subset
    exact: Subset | None
    next_patch: int
    next_gain: float
    clusters: np.ndarray
    alternatives: tuple[np.ndarray, ...]
    least: int = 1
    allowed: np.ndarray | None = None

    @property
    def sets(self) -> tuple[Subset, ...]:
        """Its sets, the exact one where it is another."""
        if self.exact is None or set(self.exact.order) == set(self.subset.order):
            return (self.subset,)
        return self.subset, self.exact

    def gap_sentence(self) -> str:
        """Say how far the greedy set is from the optimum."""
        if self.exact is None:
            return f"the exact optimum was not found within {2 * SOLVER_S:g} s"
        greedy, exact = self.subset, self.exact
        proof = "" if exact.proven else " (the best found in the time allowed, not proven)"
        score = f"{exact.mean_max_after_each[-1]:.3f} with {_sensors(exact)}"
        if exact.reached and not greedy.reached:
            return f"the exact optimum reaches the target, {score}{proof}"
        if exact.cost < greedy.cost - ROUNDING:
            return f"the exact optimum reaches {score}, greedy needs {_sensors(greedy)}{proof}"
        gain = exact.mean_max_after_each[-1] - greedy.mean_max_after_each[-1]
        if gain > ROUNDING:
            return f"the exact optimum reaches {score}, {gain:.3f} more than greedy{proof}"
        return f"greedy is as good as the exact optimum{proof}"


def advise(
    utility: UtilityMap,
    patches: PatchSet,
    target: float,
    max_places: int | None = None,
    constraints: Constraints | None = None,
) -> Advice:
    """Choose patches from a finished ranking.

    Parameters
    ----------
    utility : UtilityMap
    patches : PatchSet
        The patches ranked.
    target : float
        Mean-max F1 to reach.
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
    terms, f1 = (constraints or Constraints()).terms(patches), utility.counted_f1
    subset = greedy_subset(f1, target, max_places, **terms)
    try:
        exact = exact_subset(f1, target, max_places, **terms, time_limit_s=SOLVER_S)
    except TimeoutError:
        exact = None
    gain = np.where(terms["allowed"], marginal_gain(f1, subset.order), -1.0)
    gain[list(subset.order)] = -1.0
    clusters = redundancy_clusters(utility.predictions, len(utility.activities), SAME_OPINION)
    return Advice(
        best=best_single(utility, terms["allowed"]),
        subset=subset,
        exact=exact,
        next_patch=int(gain.argmax()) if gain.max() >= 0 else -1,
        next_gain=float(max(gain.max(), 0.0)),
        clusters=clusters,
        alternatives=tuple(
            np.flatnonzero(
                (clusters == clusters[patch])
                & utility.same_as(patch)
                & terms["allowed"]
                & (np.arange(len(clusters)) != patch)
            )
            for patch in subset.order
        ),
        least=fewest(subset.order, terms["required"]),
        allowed=terms["allowed"],
    )


def _sensors(subset: Subset) -> str:
    count = len(subset.order)
    text = f"{count} sensor{'s' if count != 1 else ''}"
    return text if abs(subset.cost - count) < ROUNDING else f"{text} at a cost of {subset.cost:g}"
