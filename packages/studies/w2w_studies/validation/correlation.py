# SPDX-License-Identifier: GPL-3.0-or-later
"""How far two signals of unknown axes go together: correlation of their magnitudes."""

from typing import NamedTuple

import numpy as np

from w2w.core.filtering import butterworth

LEAST_SAMPLES = 20


class Correlation(NamedTuple):
    """Pearson's r of two magnitudes."""

    zero_lag: float
    best_lag: float
    """Correlation without a shift, and at the shift that fits best."""
    lag_s: float  # that shift: how much later the first signal is
    amplitude: float  # standard deviation of the second magnitude over that of the first


def magnitude_correlation(
    first: np.ndarray, second: np.ndarray, rate: float, lowpass_hz: float, longest_lag_s: float
) -> Correlation:
    """Correlate the lengths of two vector signals.

    `first`, `second` (T, 3): of one rate and starting together; the longer is cut.
    `rate`: samples per second.
    `lowpass_hz`: both are low-passed before their length is taken.
    `longest_lag_s`: largest shift that is tried.
    Raises ValueError if there are too few samples.
    """
    n = min(len(first), len(second))
    reach = int(longest_lag_s * rate)
    if n - reach < LEAST_SAMPLES:
        raise ValueError(f"{n} samples are too few to compare at lags up to {longest_lag_s:g} s")
    a, b = (
        np.linalg.norm(butterworth(v[:n].T.astype(np.float64), rate, lowpass_hz, 2, zero_phase=True), axis=0)
        for v in (first, second)
    )
    lags = np.arange(-reach, reach + 1)
    found = np.array([_r(a[max(0, k) : n + min(0, k)], b[max(0, -k) : n - max(0, k)]) for k in lags])
    best = int(np.nanargmax(found))
    return Correlation(
        float(found[reach]), float(found[best]), float(lags[best] / rate), float(b.std() / a.std())
    )


def _r(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(a, b)[0, 1])
