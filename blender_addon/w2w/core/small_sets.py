# SPDX-License-Identifier: GPL-3.0-or-later
"""The best few places, by branch and bound: for up to five far faster than an integer programme."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

LARGEST = 5
"""Places up to which the search takes seconds on 512 places; each place more takes three times as long."""

ROUNDING = 1e-12


def best_small_set(
    value: np.ndarray, size: int, required: Sequence[np.ndarray] = (), at_least: float = 0.0
) -> list[int] | None:
    """The set of at most `size` places whose mean over columns of the maximum is greatest.

    The mean of maxima is submodular: what several places add is at most the sum of what each
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
        for number, place in enumerate(options.tolist()):
            others = most if unmet else gain[number + 1 : number + left].sum()
            if covered.mean() + gain[number] + others <= self.score:
                return
            rest = candidates if unmet else options[number + 1 :]
            self.extend([*chosen, place], np.maximum(covered, self.value[place]), rest, left - 1)

    def _keep(self, chosen: list[int], score: float) -> None:
        if chosen and score > self.score:
            self.best, self.score = chosen, score
