# SPDX-License-Identifier: GPL-3.0-or-later
"""What a wearer loses by putting the sensor where the simulation says instead of at the really best site."""

from typing import NamedTuple

import numpy as np

from w2w.core.ranking.agreement import bootstrap_interval


class Regret(NamedTuple):
    """Real F1 lost."""

    lost: float
    low: float
    high: float
    """Its 95 % interval over people and clips, with a new choice and best site in each draw."""
    at_random: float  # what a site chosen at random loses on average


def regret(
    real: np.ndarray, simulated: np.ndarray, real_samples: np.ndarray, simulated_samples: np.ndarray
) -> Regret:
    """Real F1 of the really best site less that of the site which simulation calls best.

    `real`, `simulated` (S, K): scores of sites by K activities; the mean over these is taken. One column for
    one score.
    `real_samples`, `simulated_samples` (B, S, K): of resamples; NaN where there is none.
    """
    found = float(lost(real, simulated))
    interval = bootstrap_interval(found, lost(real_samples, simulated_samples))
    return Regret(found, *interval, float((real.max(axis=0) - real.mean(axis=0)).mean()))


def lost(real: np.ndarray, simulated: np.ndarray) -> np.ndarray:
    """F1 lost, the mean over activities, shape (...), of scores (..., S, K).

    Sites with the same simulated score are equally likely to be taken.
    """
    chosen = simulated == np.fmax.reduce(simulated, axis=-2, keepdims=True)
    with np.errstate(invalid="ignore"):
        kept = (real * chosen).sum(axis=-2) / chosen.sum(axis=-2)
    return np.nanmean(real.max(axis=-2) - kept, axis=-1)
