# SPDX-License-Identifier: GPL-3.0-or-later
"""Where to wear: the best single patch, and small sets of patches by greedy choice or exact optimum."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ..ranking.classifiers.ridge import Ridge
from ..ranking.inputs import PatchBlocks, as_blocks
from ..ranking.utility import UtilityMap, utility_map
from .exact import LARGEST, FacilityLocation, best_small_set
from .promise import Promise
from .terms import Requirement, Terms, open_mask

ROUNDING = 1e-6
"""F1 differences smaller than this are rounding, and the solver's tolerance."""

TIE = 1e-9
"""Gains that differ by less are equal, in whatever order they were summed: the first patch is taken."""

WORKERS = 2
"""Sets tested at the same time."""


@dataclass(frozen=True)
class Subset:
    """Patches chosen one after another.

    Attributes
    ----------
    order : tuple of int
        Patches in order of choice.
    mean_max_after_each : tuple of float
        Mean over activities of the best F1 among the patches chosen so far.
    target : float
        Mean-max F1 asked for.
    reached : bool
    best_reachable : float
        Mean-max F1 of all allowed patches together: no choice can pass it.
    cost : float
        Sum of the chosen patches' costs; their number where costs are 1.
    proven : bool
        True where a solver proved that no cheaper set does as much.
    promise : Promise, optional
        What one classifier on the first patch, the first two, and so on would reach on other clips.
    """

    order: tuple[int, ...]
    mean_max_after_each: tuple[float, ...]
    target: float
    reached: bool
    best_reachable: float
    cost: float
    proven: bool = False
    promise: Promise | None = None

    def sentence(self) -> str:
        """Say in words what the set would reach on other clips, if that is known, and by the proxy."""
        if self.promise is None:
            return self.proxy_sentence()
        return f"{self.expected_sentence()}; by the proxy on these clips, {self.proxy_sentence()}"

    def expected_sentence(self) -> str:
        """What one classifier on all patches would reach on other clips."""
        if self.promise is None:
            return "what the set would reach on other clips is not known"
        count = len(self.order)
        patches = "1 patch reaches" if count == 1 else f"{count} patches worn together reach"
        return f"{patches} {self.promise.text()}"

    def proxy_sentence(self) -> str:
        """Say in words whether the target was reached by the proxy."""
        patches = "1 patch reaches" if len(self.order) == 1 else f"{len(self.order)} patches reach"
        reach = f"{patches} a mean-max F1 of {self.mean_max_after_each[-1]:.3f}"
        if self.reached:
            return f"{reach} (target {self.target:.3g})"
        return (
            f"{reach}; the target {self.target:.3g} is not reached, and "
            f"all allowed patches together reach {self.best_reachable:.3f}"
        )


def best_single(utility: UtilityMap, allowed: np.ndarray | None = None) -> int:
    """The allowed patch with the highest expected macro F1; of equals the highest on these clips."""
    open_patches = np.flatnonzero(open_mask(allowed, len(utility.mean)))
    order = np.lexsort((-utility.mean[open_patches], -utility.expected_mean[open_patches]))
    return int(open_patches[order[0]])


def marginal_gain(f1: np.ndarray, chosen: Sequence[int]) -> np.ndarray:
    """What each patch would add to the mean-max F1 of the chosen ones.

    Parameters
    ----------
    f1 : ndarray, shape (N, A)
    chosen : sequence of int

    Returns
    -------
    ndarray, shape (N,)
    """
    return _gain(np.asarray(f1, dtype=np.float64), _covered(f1, chosen))


def greedy_subset(
    f1: np.ndarray,
    target: float = 0.90,
    max_size: int | None = None,
    allowed: np.ndarray | None = None,
    required: Sequence[Requirement] = (),
    cost: np.ndarray | None = None,
) -> Subset:
    """Add the patch that raises the mean-max F1 most until the target is reached.

    The paper's proxy for several sensors worn together: each activity is recognised
    by the chosen patch that is best at it. `multi_sensor_check` tests the proxy.

    Parameters
    ----------
    f1 : ndarray, shape (N, A)
    target : float
        Mean over activities of the maximum over chosen patches to reach.
    max_size : int, optional
        Most patches.
    allowed : ndarray of bool, shape (N,), optional
        Patches that may be chosen.
    required : sequence of Requirement
        Chosen first. Several patches stand for one of them ("a wrist"), and the best is taken.
    cost : ndarray, shape (N,), optional
        What each patch costs, positive; the gain per cost decides.

    Returns
    -------
    Subset

    Raises
    ------
    ValueError
        If no patch is allowed, a required patch is not, or more are required than
        `max_size`.
    """
    terms = Terms.checked(f1, max_size, allowed, required, cost)
    return _subset(terms, greedy_order(terms, target), target)


def greedy_order(terms: Terms, target: float = np.inf) -> list[int]:
    """The patches in the order of choice of `greedy_subset`."""
    order: list[int] = []
    covered = np.zeros(terms.f1.shape[1])

    def choose(candidates: np.ndarray) -> None:
        gain_per_cost = _gain(terms.f1[candidates], covered) / terms.cost[candidates]
        order.append(int(candidates[int((gain_per_cost >= gain_per_cost.max() - TIE).argmax())]))
        np.maximum(covered, terms.f1[order[-1]], out=covered)

    for options in terms.required:
        if not np.isin(order, options).any():
            choose(options)
    while len(order) < terms.max_size and (not order or covered.mean() < target - ROUNDING):
        rest = np.setdiff1d(np.flatnonzero(terms.allowed), order)
        if order and _gain(terms.f1[rest], covered).max(initial=0.0) <= ROUNDING:
            break
        choose(rest)
    return order


def exact_subset(
    f1: np.ndarray,
    target: float = 0.90,
    max_size: int | None = None,
    allowed: np.ndarray | None = None,
    required: Sequence[Requirement] = (),
    cost: np.ndarray | None = None,
    time_limit_s: float = 60.0,
) -> Subset:
    """The cheapest set that reaches the target, and among the cheapest the best.

    Parameters
    ----------
    f1, target, max_size, allowed, required, cost
        As for `greedy_subset`. A target that no patches reach is lowered to the best
        reachable, and where `max_size` patches cannot reach it, the best set of that size
        is given.
    time_limit_s : float
        Seconds the solver may take for each of its two steps.

    Returns
    -------
    Subset
        In the order greedy choice would take its patches; `proven` is False where the
        time ran out.

    Raises
    ------
    ValueError
        As `greedy_subset`.
    TimeoutError
        If the solver found no set in the time it had.
    """
    terms = Terms.checked(f1, max_size, allowed, required, cost)
    goal = min(target, terms.best_reachable) - ROUNDING / 2
    few = _small_set(terms, goal)
    if few is not None:
        return _subset(terms, _by_gain(terms.f1, few), target, proven=True)
    open_patches, required = terms.renumbered()
    problem = FacilityLocation(
        value=terms.f1[open_patches],
        cost=terms.cost[open_patches],
        required=required,
        max_size=terms.max_size,
        time_limit_s=time_limit_s,
    )
    cheapest = problem.cheapest(goal)
    budget = None if cheapest is None else float(terms.cost[open_patches[cheapest.patches]].sum())
    best = problem.best(budget)
    proven = best.proven and (cheapest is None or cheapest.proven)
    return _subset(terms, _by_gain(terms.f1, open_patches[best.patches]), target, proven)


def multi_sensor_check(
    order: Sequence[int], inputs: np.ndarray | PatchBlocks, activity: np.ndarray, **protocol: Any
) -> list[UtilityMap]:
    """Test the mean of maxima: one classifier on the chosen sensors' signals together.

    Parameters
    ----------
    order : sequence of int
        Patches as chosen.
    inputs : ndarray or PatchBlocks, shape (W, N, D) or (W, N, samples, 6)
        Features or windows of all patches, as for `utility_map`.
    activity : array_like of str, shape (W,)
    **protocol
        The other arguments of `utility_map`; the same ones give the same folds.

    Returns
    -------
    list of UtilityMap
        For the first sensor alone, the first two together, and so on; each of one
        patch, the sensors' inputs side by side along the last axis. Their clips are not halved:
        Gram matrices of so many features by every half would take much memory.
    """
    source = as_blocks(inputs)
    alone = [source.patches(patch, patch + 1)[:, 0] for patch in order]

    def first(size: int) -> UtilityMap:
        worn = np.stack(alone[:size], axis=-2)
        together = worn.reshape(*worn.shape[:-2], -1)[:, None]
        return utility_map(together, activity, **protocol, halvings=0)

    name = protocol.get("classifier", Ridge.name)
    workers = WORKERS if name == Ridge.name else 1  # others use all processors by themselves
    with threadpool_limits(1 if workers > 1 else None), ThreadPoolExecutor(workers) as pool:
        return list(pool.map(first, range(len(order), 0, -1)))[::-1]  # what takes longest first


def _subset(terms: Terms, order: Sequence[int], target: float, proven: bool = False) -> Subset:
    order = [int(patch) for patch in order]
    values = np.maximum.accumulate(terms.f1[order], axis=0).mean(axis=1)
    return Subset(
        order=tuple(order),
        mean_max_after_each=tuple(values.tolist()),
        target=target,
        reached=bool(values[-1] >= target - ROUNDING),
        best_reachable=terms.best_reachable,
        cost=float(terms.cost[order].sum()),
        proven=proven,
    )


def exact_order(terms: Terms, size: int) -> list[int]:
    """The best set of a size, in the order greedy choice would take its patches.

    Of more than a few patches, or of such that differ in cost, what greedy choice takes.
    """
    terms = replace(terms, max_size=size)
    if size > LARGEST or np.ptp(terms.cost) > 0:
        return greedy_order(terms)[:size]
    open_patches, required = terms.renumbered()
    few = best_small_set(terms.f1[open_patches], size, required)
    return greedy_order(terms)[:size] if few is None else _by_gain(terms.f1, open_patches[few])


def _small_set(terms: Terms, goal: float) -> np.ndarray | None:
    """The smallest set that reaches the goal, or the best of the size allowed; None where it is not small."""
    if np.ptp(terms.cost) > 0:
        return None
    greedy = greedy_subset(terms.f1, goal, terms.max_size, terms.allowed, terms.required)
    if min(len(greedy.order), terms.max_size) > 2 * LARGEST:
        return None  # the optimum is hardly that much smaller
    open_patches, required = terms.renumbered()
    for size in range(1, min(terms.max_size, LARGEST) + 1):
        enough = len(greedy.order) <= size
        known = greedy.mean_max_after_each[-1] if enough else 0.0
        few = best_small_set(terms.f1[open_patches], size, required, known)
        if few is None:
            continue
        reached = terms.f1[open_patches[few]].max(axis=0).mean() >= goal
        if reached or size == terms.max_size:
            return open_patches[few]
    return None


def _covered(f1: np.ndarray, chosen: Sequence[int]) -> np.ndarray:
    """Best F1 of the chosen patches by activity, 0 where none is chosen."""
    return f1[list(chosen)].max(axis=0, initial=0.0)


def _gain(f1: np.ndarray, covered: np.ndarray) -> np.ndarray:
    return np.maximum(f1 - covered, 0.0).mean(axis=1)


def _by_gain(f1: np.ndarray, patches: np.ndarray) -> list[int]:
    """The patches in the order greedy choice would take them."""
    order: list[int] = []
    for _ in patches:
        rest = np.setdiff1d(patches, order)
        order.append(int(rest[_gain(f1[rest], _covered(f1, order)).argmax()]))
    return order
