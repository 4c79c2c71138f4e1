# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sets of patches: by algorithm 2, which is greedy, and the exact optimum of its proxy."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from w2w.core.ranking.weights import alike
from w2w.core.selection.constraints import Terms
from w2w.core.selection.promise import Promise

from .exact import FacilityLocation

Requirement = int | Sequence[int]
"""A patch that must be chosen, or several of which one must be."""

ROUNDING = 1e-6
"""F1 differences smaller than this are rounding, and the solver's tolerance."""

TIE = 1e-9
"""Gains that differ by less are equal, in whatever order they were summed: the first patch is taken."""

SOLVER_S = 10.0
"""Seconds that the solver may take for each programme."""


def counted_columns(f1: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Scores (N, A) without the activities that do not count, the others scaled by their weights.

    The plain mean over columns is then the weighted mean, and so is that of the maxima over patches: choosing
    sets by plain means is choosing by the weights.
    """
    if alike(weights):
        return f1
    counted = np.flatnonzero(weights)
    return f1[:, counted] * (weights[counted] / weights[counted].mean())


@dataclass(frozen=True)
class Subset:
    """Patches chosen one after another."""

    order: tuple[int, ...]  # patches in order of choice
    mean_max_after_each: tuple[float, ...]
    """Mean over activities of the best F1 among the patches chosen so far."""
    target: float  # mean-max F1 asked for
    reached: bool
    best_reachable: float  # mean-max F1 of all allowed patches together: no choice can pass it
    cost: float  # sum of the chosen patches' costs; their number where costs are 1
    proven: bool = False  # true where a solver proved that no cheaper set does as much
    promise: Promise | None = None
    """What one classifier on the first patch, the first two, and so on would reach on other clips."""

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
    by the chosen patch that is best at it. `joint_test.multi_sensor_check` tests the proxy.

    `f1` (N, A).
    `target`: mean over activities of the maximum over chosen patches to reach.
    `max_size`: most patches.
    `allowed` bool (N,): patches that may be chosen.
    `required`: chosen first. Several patches stand for one of them ("a wrist"), and the best is taken.
    `cost` (N,): what each patch costs, positive; the gain per cost decides.
    Raises ValueError if no patch is allowed, a required patch is not, or more are required than `max_size`.
    """
    f1 = np.asarray(f1, dtype=np.float64)
    terms = checked_terms(len(f1), max_size, allowed, required, cost)
    return _subset(f1, terms, greedy_order(f1, terms, target), target)


def checked_terms(
    n_patches: int,
    max_size: int | None = None,
    allowed: np.ndarray | None = None,
    required: Sequence[Requirement] = (),
    cost: np.ndarray | None = None,
) -> Terms:
    """Terms from the arguments of `greedy_subset`; ValueErrors are its."""
    mask = np.ones(n_patches, bool) if allowed is None else np.asarray(allowed, dtype=bool)
    if mask.shape != (n_patches,):
        raise ValueError(f"allowed must have shape ({n_patches},), not {mask.shape}")
    if not mask.any():
        raise ValueError("no patch is allowed: the constraints leave nothing to choose from")
    price = np.ones(n_patches) if cost is None else np.asarray(cost, dtype=np.float64)
    if price.shape != (n_patches,) or not (np.isfinite(price) & (price > 0)).all():
        raise ValueError(f"cost must hold {n_patches} positive numbers, one a patch")
    options = []
    for wish in required:
        patches = np.atleast_1d(np.asarray(wish, dtype=np.int64))
        if not mask[patches].any():
            raise ValueError(f"one of the patches {patches.tolist()} is required, but none is allowed")
        options.append(patches[mask[patches]])
    limit = int(mask.sum()) if max_size is None else max_size
    if limit < max(1, len(options)):
        raise ValueError(f"max_size is {limit}, but {max(1, len(options))} patches are required")
    return Terms(mask, options, price, limit)


def greedy_order(f1: np.ndarray, terms: Terms, target: float = np.inf) -> list[int]:
    """The patches in the order of choice of `greedy_subset`."""
    order: list[int] = []
    covered = np.zeros(f1.shape[1])

    def choose(candidates: np.ndarray) -> None:
        gain_per_cost = _gain(f1[candidates], covered) / terms.price[candidates]
        order.append(int(candidates[int((gain_per_cost >= gain_per_cost.max() - TIE).argmax())]))
        np.maximum(covered, f1[order[-1]], out=covered)

    for options in terms.required:
        if not np.isin(order, options).any():
            choose(options)
    while len(order) < terms.max_size and (not order or covered.mean() < target - ROUNDING):
        rest = np.setdiff1d(np.flatnonzero(terms.allowed), order)
        if order and _gain(f1[rest], covered).max(initial=0.0) <= ROUNDING:
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
    time_limit_s: float = SOLVER_S,
) -> Subset:
    """The cheapest set that reaches the target, and among the cheapest the best.

    `f1`, `target`, `max_size`, `allowed`, `required`, `cost`: as for `greedy_subset`. A target that no
    patches reach is lowered to the best reachable, and where `max_size` patches cannot reach it, the best set
    of that size is given.
    `time_limit_s`: seconds that the solver may take for each of its two steps.
    Returns its patches in the order in which greedy choice would take them; `proven` is False if the time
    ran out.
    Raises ValueError as `greedy_subset`.
    Raises TimeoutError if the solver found no set in the time it had.
    """
    f1 = np.asarray(f1, dtype=np.float64)
    terms = checked_terms(len(f1), max_size, allowed, required, cost)
    programme = _programme(f1, terms, time_limit_s)
    cheapest = programme.cheapest(min(target, _best_reachable(f1, terms)) - ROUNDING / 2)
    budget = None if cheapest is None else float(terms.price[cheapest.patches].sum())
    best = programme.best(budget)
    proven = best.proven and (cheapest is None or cheapest.proven)
    return _subset(f1, terms, _by_gain(f1, best.patches), target, proven)


def _subset(
    f1: np.ndarray, terms: Terms, order: Sequence[int], target: float, proven: bool = False
) -> Subset:
    order = [int(patch) for patch in order]
    values = np.maximum.accumulate(f1[order], axis=0).mean(axis=1)
    return Subset(
        order=tuple(order),
        mean_max_after_each=tuple(values.tolist()),
        target=target,
        reached=bool(values[-1] >= target - ROUNDING),
        best_reachable=_best_reachable(f1, terms),
        cost=float(terms.price[order].sum()),
        proven=proven,
    )


def exact_order(f1: np.ndarray, terms: Terms, size: int) -> list[int]:
    """The best set of at most a size, in the order greedy choice would take its patches.

    Of patches that differ in cost, and where the solver finds none in time, what greedy choice takes.
    """
    terms = replace(terms, max_size=size)
    if np.ptp(terms.price) == 0:
        try:
            return _by_gain(f1, _programme(f1, terms, SOLVER_S).best().patches)
        except TimeoutError:
            pass
    return greedy_order(f1, terms)[:size]


def _programme(f1: np.ndarray, terms: Terms, time_limit_s: float) -> FacilityLocation:
    return FacilityLocation(f1, terms.price, terms.allowed, terms.required, terms.max_size, time_limit_s)


def _best_reachable(f1: np.ndarray, terms: Terms) -> float:
    return float(f1[terms.allowed].max(axis=0).mean())


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
