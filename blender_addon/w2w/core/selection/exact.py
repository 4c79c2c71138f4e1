# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact choice of facilities by mixed integer linear programming."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import block_array, csr_array, eye_array, hstack, kron

INFEASIBLE = 2
"""SciPy's status of a programme without a solution."""


class Choice(NamedTuple):
    """Facilities opened, and whether the solver proved that none does better."""

    patches: np.ndarray
    proven: bool


class FacilityLocation:
    """Open facilities so that each client, served by the best open one, is served well.

    x_n is 1 where facility n is open; z_an <= x_n is the share of client a that n
    serves. Solved by HiGHS (Huangfu and Hall 2018, doi:10.1007/s12532-017-0130-5).

    Parameters
    ----------
    value : ndarray, shape (N, A)
        What a client gets from each facility.
    cost : ndarray, shape (N,)
        Cost of opening each.
    required : sequence of ndarray of int
        Of each of these groups at least one must be open.
    max_size : int
        Most facilities open.
    time_limit_s : float
        Seconds the solver may take for one programme.
    """

    def __init__(
        self,
        value: np.ndarray,
        cost: np.ndarray,
        required: Sequence[np.ndarray],
        max_size: int,
        time_limit_s: float,
    ) -> None:
        self.n_patches, n_clients = value.shape
        self.time_limit_s = time_limit_s
        unused = np.zeros(self.n_patches * n_clients)
        self.cost = np.concatenate([cost, unused])
        self.mean_value = np.concatenate([np.zeros(self.n_patches), value.T.ravel() / n_clients])
        each_client = kron(eye_array(n_clients), np.ones((1, self.n_patches)))
        closed_serves_none = hstack(
            [-kron(np.ones((n_clients, 1)), eye_array(self.n_patches)), eye_array(unused.size)], format="csr"
        )
        self.rows = [
            LinearConstraint(
                block_array([[csr_array((n_clients, self.n_patches)), each_client]], format="csr"), 1, 1
            ),
            LinearConstraint(closed_serves_none, -np.inf, 0),
            LinearConstraint(self._count(np.arange(self.n_patches)), -np.inf, max_size),
            *(LinearConstraint(self._count(group), 1, np.inf) for group in required),
        ]

    def cheapest(self, at_least: float) -> Choice | None:
        """The cheapest choice whose mean value over clients is `at_least`; None if there is none."""
        return self._solve(self.cost, LinearConstraint(self.mean_value[None], at_least, np.inf))

    def best(self, at_most_cost: float | None = None) -> Choice:
        """The choice of greatest mean value, within a budget.

        Raises
        ------
        ValueError
            If the requirements cannot be met together.
        """
        budget = np.inf if at_most_cost is None else at_most_cost * (1 + 1e-9)
        choice = self._solve(-self.mean_value, LinearConstraint(self.cost[None], -np.inf, budget))
        if choice is None:
            raise ValueError("the requirements cannot be met together within the size and the budget")
        return choice

    def _count(self, group: np.ndarray) -> np.ndarray:
        row = np.zeros((1, self.mean_value.size))
        row[0, group] = 1.0
        return row

    def _solve(self, objective: np.ndarray, goal: LinearConstraint) -> Choice | None:
        result = milp(
            objective,
            constraints=[*self.rows, goal],
            bounds=Bounds(0, 1),
            integrality=np.arange(objective.size) < self.n_patches,
            options={"time_limit": self.time_limit_s, "mip_rel_gap": 1e-6},
        )
        if result.status == INFEASIBLE:
            return None
        if result.x is None:
            raise TimeoutError(f"no choice was found in {self.time_limit_s:g} s: {result.message}")
        return Choice(np.flatnonzero(result.x[: self.n_patches] > 0.5), result.status == 0)


LARGEST = 5
"""Patches up to which the search takes seconds on 512 patches; each patch more takes three times as long."""

ROUNDING = 1e-12


def best_small_set(
    value: np.ndarray, size: int, required: Sequence[np.ndarray] = (), at_least: float = 0.0
) -> list[int] | None:
    """The set of at most `size` patches whose mean over columns of the maximum is greatest.

    The mean of maxima is submodular: what several patches add is at most the sum of what each
    adds alone, which bounds every branch (Nemhauser, Wolsey and Fisher 1978,
    doi:10.1007/BF01588971).

    Parameters
    ----------
    value : ndarray, shape (N, A)
        Not negative.
    size : int
    required : sequence of ndarray of int
        Of each of these groups at least one must be taken.
    at_least : float
        Sets of a lower mean are not wanted.

    Returns
    -------
    list of int or None
        None where no set meets the requirements and `at_least`.
    """
    search = _Search(np.asarray(value, dtype=np.float64), list(required), at_least - ROUNDING)
    search.extend([], np.zeros(value.shape[1]), np.arange(len(value)), min(size, len(value)))
    return search.best


class _Search:
    """The best set found so far."""

    def __init__(self, value: np.ndarray, required: list[np.ndarray], at_least: float) -> None:
        self.value = value
        self.required = required
        self.score = at_least
        self.best: list[int] | None = None

    def extend(self, chosen: list[int], covered: np.ndarray, candidates: np.ndarray, left: int) -> None:
        """Look for something better among the sets that hold `chosen` and up to `left` candidates more."""
        unmet = [group for group in self.required if not np.isin(chosen, group).any()]
        if not unmet:
            self._keep(chosen, covered.mean())
        if left == 0:
            return
        options = np.intersect1d(candidates, unmet[0]) if unmet else candidates
        if left == 1:
            for group in unmet[1:]:
                options = np.intersect1d(options, group)
        if not len(options):
            return
        gain = np.maximum(self.value[options] - covered, 0.0).mean(axis=1)
        if left == 1:
            last = int(gain.argmax())
            self._keep([*chosen, int(options[last])], covered.mean() + gain[last])
            return
        order = np.argsort(-gain, kind="stable")
        options, gain = options[order], gain[order]
        most = np.sort(np.maximum(self.value[candidates] - covered, 0.0).mean(axis=1))[::-1][: left - 1].sum()
        for number, patch in enumerate(options.tolist()):
            others = most if unmet else gain[number + 1 : number + left].sum()
            if covered.mean() + gain[number] + others <= self.score:
                return
            rest = candidates if unmet else options[number + 1 :]
            self.extend([*chosen, patch], np.maximum(covered, self.value[patch]), rest, left - 1)

    def _keep(self, chosen: list[int], score: float) -> None:
        if chosen and score > self.score:
            self.best, self.score = chosen, score
