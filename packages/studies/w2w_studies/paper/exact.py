# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact choice of facilities by mixed integer linear programming."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
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

    `value` (N, A): what a client gets from each facility.
    `cost` (N,): cost of opening each.
    `allowed` bool (N,): facilities that may be opened.
    `required`: of each of these groups at least one must be open.
    `max_size`: most facilities open.
    `time_limit_s`: seconds the solver may take for one programme.
    """

    def __init__(
        self,
        value: np.ndarray,
        cost: np.ndarray,
        allowed: np.ndarray,
        required: Sequence[np.ndarray],
        max_size: int,
        time_limit_s: float,
    ) -> None:
        self.n_patches, n_clients = value.shape
        self.time_limit_s = time_limit_s
        self.most_open = np.concatenate([allowed, np.ones(self.n_patches * n_clients)]).astype(float)
        unused = np.zeros(self.n_patches * n_clients)
        self.cost = np.concatenate([cost, unused])
        self.mean_value = np.concatenate([np.zeros(self.n_patches), value.T.ravel() / n_clients])
        each_client = kron(eye_array(n_clients), np.ones((1, self.n_patches)))
        closed_serves_none = hstack(
            [-kron(np.ones((n_clients, 1)), eye_array(self.n_patches)), eye_array(unused.size)], format="csr"
        )
        self.rows = [
            scipy.optimize.LinearConstraint(
                block_array([[csr_array((n_clients, self.n_patches)), each_client]], format="csr"), 1, 1
            ),
            scipy.optimize.LinearConstraint(closed_serves_none, -np.inf, 0),
            scipy.optimize.LinearConstraint(self._count(np.arange(self.n_patches)), -np.inf, max_size),
            *(scipy.optimize.LinearConstraint(self._count(group), 1, np.inf) for group in required),
        ]

    def cheapest(self, at_least: float) -> Choice | None:
        """The cheapest choice whose mean value over clients is `at_least`; None if there is none."""
        return self._solve(
            self.cost, scipy.optimize.LinearConstraint(self.mean_value[None], at_least, np.inf)
        )

    def best(self, at_most_cost: float | None = None) -> Choice:
        """The choice of greatest mean value, within a budget.

        Raises ValueError if the requirements cannot be met together.
        """
        budget = np.inf if at_most_cost is None else at_most_cost * (1 + 1e-9)
        choice = self._solve(
            -self.mean_value, scipy.optimize.LinearConstraint(self.cost[None], -np.inf, budget)
        )
        if choice is None:
            raise ValueError("the requirements cannot be met together within the size and the budget")
        return choice

    def _count(self, group: np.ndarray) -> np.ndarray:
        row = np.zeros((1, self.mean_value.size))
        row[0, group] = 1.0
        return row

    def _solve(self, objective: np.ndarray, goal: scipy.optimize.LinearConstraint) -> Choice | None:
        result = scipy.optimize.milp(
            objective,
            constraints=[*self.rows, goal],
            bounds=scipy.optimize.Bounds(0, self.most_open),
            integrality=np.arange(objective.size) < self.n_patches,
            options={"time_limit": self.time_limit_s, "mip_rel_gap": 1e-6},
        )
        if result.status == INFEASIBLE:
            return None
        if result.x is None:
            raise TimeoutError(f"no choice was found in {self.time_limit_s:g} s: {result.message}")
        return Choice(np.flatnonzero(result.x[: self.n_patches] > 0.5), result.status == 0)
