# SPDX-License-Identifier: GPL-3.0-or-later
"""Readings of sensors that each keep their own time, brought to one clock."""

from collections.abc import Sequence

import numpy as np


def shared_times(times: Sequence[np.ndarray], rate: float, shortest_s: float) -> np.ndarray:
    """Evenly spaced instants over the time that all sensors share.

    `times` (T,): increasing, s.
    Raises ValueError if they share less than `shortest_s`.
    """
    start, end = max(of[0] for of in times), min(of[-1] for of in times)
    if end - start < shortest_s:
        raise ValueError(f"its sensors share less than {shortest_s:g} s")
    return start + np.arange(int((end - start) * rate) + 1) / rate


def at_times(known: np.ndarray, values: np.ndarray, times: np.ndarray, longest_step_s: float) -> np.ndarray:
    """Straight lines between samples; NaN where samples were lost.

    `values` (T, K), `times` (M,).
    `known` (T,): when the samples were taken, increasing.
    `longest_step_s`: samples further apart have lost what was between them.
    Returns (M, K).
    """
    found = np.stack([np.interp(times, known, column) for column in values.T], axis=1)
    after = np.clip(np.searchsorted(known, times), 1, len(known) - 1)
    found[known[after] - known[after - 1] > longest_step_s] = np.nan
    return found
