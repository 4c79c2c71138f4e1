# SPDX-License-Identifier: GPL-3.0-or-later
"""Where to wear: the best single place, small sets of places, and places that say the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .utility import UtilityMap

NO_GAIN = 1e-9
"""Gains smaller than this are rounding."""


@dataclass(frozen=True)
class Subset:
    """Places chosen one after another.

    Attributes
    ----------
    order : tuple of int
        Places in order of choice.
    mean_max_after_each : tuple of float
        Mean over activities of the best F1 among the places chosen so far.
    target : float
        Mean-max F1 asked for.
    reached : bool
    best_reachable : float
        Mean-max F1 of all allowed places together: no choice can pass it.
    cost : float
        Sum of the chosen places' costs; their number where costs are 1.
    """

    order: tuple[int, ...]
    mean_max_after_each: tuple[float, ...]
    target: float
    reached: bool
    best_reachable: float
    cost: float

    def sentence(self) -> str:
        """Say in words whether the target was reached."""
        places = f"{len(self.order)} place{'s' if len(self.order) != 1 else ''}"
        value = self.mean_max_after_each[-1] if self.order else 0.0
        if self.reached:
            return f"{places} reach a mean-max F1 of {value:.3f} (target {self.target:g})"
        return (
            f"{places} reach a mean-max F1 of {value:.3f}; the target {self.target:g} is not reached, and "
            f"all allowed places together reach {self.best_reachable:.3f}"
        )


def best_single(utility: UtilityMap, allowed: np.ndarray | None = None) -> int:
    """The allowed place with the highest macro F1; the first of equals."""
    return int(np.where(_mask(allowed, len(utility.mean)), utility.mean, -np.inf).argmax())


def greedy_subset(
    f1: np.ndarray,
    target: float = 0.90,
    max_size: int | None = None,
    allowed: np.ndarray | None = None,
    required: Sequence[int | Sequence[int]] = (),
    cost: np.ndarray | None = None,
) -> Subset:
    """Add the place that raises the mean-max F1 most until the target is reached.

    The paper's proxy for several sensors worn together: each activity is recognised
    by the chosen place that is best at it.

    Parameters
    ----------
    f1 : ndarray, shape (N, A)
    target : float
        Mean over activities of the maximum over chosen places to reach.
    max_size : int, optional
        Most places.
    allowed : ndarray of bool, shape (N,), optional
        Places that may be chosen.
    required : sequence of int or of sequences of int
        Places that must be chosen first; a sequence of places stands for one of them
        ("a wrist"), and the best is taken.
    cost : ndarray, shape (N,), optional
        What each place costs, positive; the gain per cost decides.

    Returns
    -------
    Subset

    Raises
    ------
    ValueError
        If no place is allowed, a required place is not, or more are required than
        `max_size`.
    """
    f1 = np.asarray(f1, dtype=np.float64)
    open_places = _mask(allowed, len(f1))
    price = _prices(cost, len(f1))
    options = _required_options(required, open_places, max_size)
    limit = int(open_places.sum()) if max_size is None else max_size
    reachable = f1[open_places].max(axis=0).mean()

    order: list[int] = []
    values: list[float] = []
    covered = np.zeros(f1.shape[1])

    def choose(candidates: np.ndarray) -> None:
        gain = marginal_gain(f1, covered)[candidates]
        order.append(int(candidates[(gain / price[candidates]).argmax()]))
        np.maximum(covered, f1[order[-1]], out=covered)
        values.append(float(covered.mean()))

    for places in options:
        if not np.isin(order, places).any():
            choose(places)
    while len(order) < limit and covered.mean() < target - NO_GAIN:
        rest = np.setdiff1d(np.flatnonzero(open_places), order)
        if not len(rest) or marginal_gain(f1, covered)[rest].max() <= NO_GAIN:
            break
        choose(rest)
    reached = bool(covered.mean() >= target - NO_GAIN)
    return Subset(tuple(order), tuple(values), target, reached, float(reachable), float(price[order].sum()))


def marginal_gain(f1: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """What each place would add to the mean-max F1 of a set.

    Parameters
    ----------
    f1 : ndarray, shape (N, A)
    covered : ndarray, shape (A,)
        Best F1 of the set by activity: ``f1[list(order)].max(axis=0)``.

    Returns
    -------
    ndarray, shape (N,)
    """
    return np.maximum(f1 - covered, 0.0).mean(axis=1)


def _mask(allowed: np.ndarray | None, n_places: int) -> np.ndarray:
    mask = np.ones(n_places, bool) if allowed is None else np.asarray(allowed, dtype=bool)
    if mask.shape != (n_places,):
        raise ValueError(f"allowed must have shape ({n_places},), not {mask.shape}")
    if not mask.any():
        raise ValueError("no place is allowed: the constraints leave nothing to choose from")
    return mask


def _prices(cost: np.ndarray | None, n_places: int) -> np.ndarray:
    price = np.ones(n_places) if cost is None else np.asarray(cost, dtype=np.float64)
    if price.shape != (n_places,) or not (price > 0).all():
        raise ValueError(f"cost must hold {n_places} positive numbers, one a place")
    return price


def _required_options(
    required: Sequence[int | Sequence[int]], allowed: np.ndarray, max_size: int | None
) -> list[np.ndarray]:
    """The allowed places among which each requirement lets one choose."""
    options = []
    for wish in required:
        places = np.atleast_1d(np.asarray(wish, dtype=np.int64))
        if not allowed[places].any():
            raise ValueError(f"place {places.tolist()} is required, but the constraints forbid it")
        options.append(places[allowed[places]])
    if max_size is not None and len(options) > max_size:
        raise ValueError(f"{len(options)} places are required, but at most {max_size} may be chosen")
    return options
