# SPDX-License-Identifier: GPL-3.0-or-later
"""Readings of sensors that each keep their own time, brought to one clock."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..filtering import count_resampled, resample
from ..motion.motion import LABELS
from .recording import ImuRecording

SAME_RATE = 0.01
"""Share by which the rates of sensors may differ and count as one."""


def in_order(times: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Some rows of a table, by their times and one for each."""
    order = rows[np.argsort(times[rows], kind="stable")]
    return order[np.diff(times[order], prepend=-np.inf) > 0]


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


def at_rate(recording: ImuRecording, rate: float) -> ImuRecording:
    """Specific force and angular velocity at another rate, low-passed; what was lost stays lost."""
    if abs(recording.rate - rate) <= SAME_RATE * rate:
        return replace(recording, rate=rate)
    old, n, found = recording.time, recording.n_samples, []
    nearest = np.arange(count_resampled(n, recording.rate, rate)) * recording.rate / rate
    for values in (recording.acc, recording.gyr):
        flat = values.reshape(n, -1).astype(np.float64)
        lost = np.isnan(flat)
        for column, missing in zip(flat.T, lost.T, strict=True):
            if missing.any() and not missing.all():
                column[missing] = np.interp(old[missing], old[~missing], column[~missing])
        new = resample(flat.T, recording.rate, rate).T
        new[lost[np.clip(np.rint(nearest).astype(int), 0, n - 1)]] = np.nan
        found.append(new.reshape(-1, *values.shape[1:]))
    labels = {name: getattr(recording, name) for name in LABELS}
    return ImuRecording(found[0], found[1], rate, recording.sites, **labels)
