# SPDX-License-Identifier: GPL-3.0-or-later
"""Advice for a designer: the best spot, the sensors to wear together, equivalent patches."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from ..patches.card import Card, make_card
from ..ranking.stream import Stream
from ..ranking.utility import UtilityMap
from ..ranking.weights import mean_over
from .answer import Answer, find_answer
from .constraints import Constraints, Terms
from .headline import mean_caution
from .joint import WORTH, WornSet, choose_together
from .scored import ScoredMap, product_patches
from .set_tests import SetTests

WINDOWS_AT_ONCE = 4096
"""Windows whose predictions are correlated at once, so that memory does not grow with the library."""

SWAPS = 2
"""Patches tried in place of each patch of a set."""

SAME_OPINION = 0.8
"""Mean correlation of predictions from which patches are grouped as equivalent."""


def prediction_correlation(predictions: np.ndarray, n_activities: int) -> np.ndarray:
    """Correlation (N, N), float64, between the predictions (W, N) of every two patches.

    Gorodkin's R_K (2004, doi:10.1016/j.compbiolchem.2004.09.006), the correlation
    coefficient of two classifications: 1 if two patches always predict the same activity,
    correctly or not, and 0 if they agree no more than by chance. A patch that always predicts one activity
    correlates 0 with all others.
    """
    n_windows, n_patches = predictions.shape
    parts = [predictions[first : first + WINDOWS_AT_ONCE] for first in range(0, n_windows, WINDOWS_AT_ONCE)]
    covariance = np.zeros((n_patches, n_patches))
    for activity in range(n_activities):
        mean = sum((part == activity).sum(axis=0) for part in parts) / n_windows
        for part in parts:
            deviation = (part == activity).astype(np.float32) - mean.astype(np.float32)
            covariance += deviation.T @ deviation
    variance = np.diag(covariance).copy()
    variance[variance <= 0] = np.inf
    correlation = covariance / np.sqrt(np.outer(variance, variance))
    np.fill_diagonal(correlation, 1.0)
    return correlation


def redundancy_clusters(
    predictions: np.ndarray, n_activities: int, correlation: float = SAME_OPINION
) -> np.ndarray:
    """Cluster of each patch, shape (N,), int, 0 the largest, by how its predictions (W, N) correlate.

    Average linkage: within a cluster the mean correlation between the parts last joined
    is at least `correlation`, above 0 and up to 1; higher makes more and smaller clusters.
    """
    n_patches = predictions.shape[1]
    if n_patches == 1:
        return np.zeros(1, dtype=np.int64)
    distance = np.clip(1.0 - prediction_correlation(predictions, n_activities), 0.0, 2.0)
    np.fill_diagonal(distance, 0.0)
    tree = linkage(squareform(distance, checks=False), method="average")
    cluster = fcluster(tree, 1.0 - correlation + 1e-9, criterion="distance") - 1
    by_size = np.argsort(-np.bincount(cluster), kind="stable")
    return np.argsort(by_size)[cluster]


@dataclass(frozen=True, eq=False)
class Advice:
    """Where to wear, under a designer's constraints."""

    best: int  # allowed patch with the highest expected macro F1
    answer: Answer  # where to wear one sensor
    worn: WornSet | None  # the patches to wear together; None if nothing tests sets
    alternatives: tuple[np.ndarray, ...]  # for each of these: at most two patches that can take its place
    clusters: np.ndarray  # (N,), int: as from `redundancy_clusters`
    cards: tuple[Card, ...]  # where each sensor recommended goes: those of the answer, then of the set
    products: dict[int, str]  # the patches at which usual products sit, with side and name
    allowed: np.ndarray  # (N,), bool: patches that the constraints leave; all by default


def advise(
    scored: ScoredMap,
    tests: SetTests | None,
    target: float = 0.9,
    every_activity: float = 0.0,
    max_places: int | None = None,
    constraints: Constraints | None = None,
    stream: Stream | None = None,
) -> Advice:
    """Choose patches from a finished ranking: sets by their `tests`, else the best spot alone.

    `target` and `every_activity` are as for `choose_together`. Sets are chosen among the places of usual
    products unless a constraint says which patches to use, by F1 in a `stream` if there is one. A
    ValueError says which constraints cannot be met.
    """
    constraints = constraints or Constraints()
    utility, patches, body = scored.utility, scored.patches, scored.body
    terms = constraints.terms(patches, max_places)
    scored = replace(scored, limits=terms.allowed)
    to_one, products = find_answer(scored), product_patches(patches, body)
    worn: WornSet | None = None
    swaps: tuple[np.ndarray, ...] = ()
    if tests:
        among = _at_products(terms, products, constraints)
        first = scored.utility.expected_mean.copy()
        first[to_one.patch] += 1  # sets begin with the answer
        few = mean_caution(utility)
        worn = choose_together(tests, utility.expected, among, target, every_activity, stream, first, few)
        swaps = interchangeable(tests, worn, among, utility)
    recommended = dict.fromkeys([to_one.patch, *(worn.order if worn else ())])
    clusters = redundancy_clusters(utility.predictions, len(utility.activities))
    cards = tuple(make_card(body, patches, utility.expected_mean, patch) for patch in recommended)
    return Advice(
        best=scored.best, answer=to_one, worn=worn, alternatives=swaps, clusters=clusters, cards=cards,
        products=products, allowed=terms.allowed,
    )  # fmt: skip


def _at_products(terms: Terms, products: dict[int, str], constraints: Constraints) -> Terms:
    """The terms with only those allowed patches at which products sit, and those that must be chosen.

    All that are allowed if a wish says which patches to use, or no product sits on any.
    """
    rarity = np.full(len(terms.allowed), len(products))
    rarity[list(products)] = np.arange(len(products))
    sits, terms = rarity < len(products), replace(terms, rarity=rarity)
    if constraints != Constraints():
        every = np.ones(len(sits), bool)
        free = Terms(every, [], every.astype(float), terms.max_size)
        terms = replace(terms, unwished=_at_products(free, products, Constraints()))
    sits[np.concatenate([np.empty(0, int), *terms.required])] = True
    sits &= terms.allowed
    if constraints.only or not sits.any():
        return terms
    return replace(terms, allowed=sits, max_size=min(terms.max_size, int(sits.sum())))


def interchangeable(
    tests: SetTests, worn: WornSet, terms: Terms, utility: UtilityMap
) -> tuple[np.ndarray, ...]:
    """For each patch of a set, the at most two patches with the most similar predictions, to take its place.

    With them the set's macro F1 on the clips that chose it falls by no more than `WORTH`.
    """
    order, alternatives = list(worn.order), []
    for number, patch in enumerate(order):
        rest = order[:number] + order[number + 1 :]
        others = [options for options in terms.required if patch in options and not set(rest) & set(options)]
        free = np.setdiff1d(others[0] if others else np.flatnonzero(terms.allowed), order)
        if not len(free):
            alternatives.append(free)
            continue
        among = utility.predictions[:, [patch, *free]]
        similar = prediction_correlation(among, len(utility.activities))[0, 1:]
        first = free[np.argsort(-similar, kind="stable")[:SWAPS]]
        f1 = tests.whole.f1_of_firsts([[*rest, int(swap)] for swap in first], [len(order)])[:, -1]
        alternatives.append(first[mean_over(f1, tests.weights) >= worn.raw_mean[-1] - WORTH])
    return tuple(alternatives)
