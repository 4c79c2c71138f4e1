# SPDX-License-Identifier: GPL-3.0-or-later
"""How a map shifts when an assumption of the study changes, against clips drawn again."""

from dataclasses import dataclass

import numpy as np

from w2w.core.ranking.agreement import rank_agreement, spearman_rows
from w2w.core.ranking.utility import UtilityMap


@dataclass(frozen=True, eq=False)
class Shift:
    """How a map differs from the usual one over the same patches."""

    rho: float
    low: float
    high: float
    """Spearman's rho of macro F1 over the patches, and its bootstrap interval over clips, the same clips
    resampled in both maps where they were tested on the same."""
    gain: float
    gain_low: float
    gain_high: float
    """Difference of macro F1, the mean over patches, and its interval with the same clips resampled in both;
    NaN where the two maps were not tested on the same clips."""
    best_holds: bool  # whether the usual best patch cannot be told from the best one now
    risen: np.ndarray
    fallen: np.ndarray
    """Patches whose rank is better or worse for sure: the intervals of the rank do not overlap."""


def compare_maps(usual: UtilityMap, other: UtilityMap, seed: int = 0) -> Shift:
    """Compare a map with the usual one.

    `usual`, `other`: of the same patches; made with the same seed, their bootstraps drew the same clips.
    Raises ValueError if the maps are not of the same patches, or of fewer than three.
    """
    agreement = rank_agreement(
        usual.mean, other.mean, usual.mean_samples, other.mean_samples, resamples=100, seed=seed
    )
    low, high = agreement.low, agreement.high
    gain, gain_low, gain_high = float(other.mean.mean() - usual.mean.mean()), np.nan, np.nan
    if _same_clips(usual, other):
        tail = [(1 - usual.level) / 2, (1 + usual.level) / 2]
        low, high = np.nanquantile(spearman_rows(usual.mean_samples, other.mean_samples), tail)
        difference = other.mean_samples.mean(axis=1) - usual.mean_samples.mean(axis=1)
        gain_low, gain_high = np.quantile(difference, tail)
    lead = other.mean_samples[:, other.mean.argmax()] - other.mean_samples[:, usual.mean.argmax()]
    least, most = np.quantile(lead, [(1 - usual.level) / 2, (1 + usual.level) / 2])
    return Shift(
        rho=agreement.spearman,
        low=float(low),
        high=float(high),
        gain=gain,
        gain_low=float(gain_low),
        gain_high=float(gain_high),
        best_holds=bool(least <= 0 <= most),
        risen=np.flatnonzero(other.rank_high < usual.rank_low),
        fallen=np.flatnonzero(other.rank_low > usual.rank_high),
    )


def resampled_clips(usual: UtilityMap, seed: int = 0) -> tuple[float, float]:
    """Interval of Spearman's rho of a map with itself, its clips drawn again with replacement.

    What lies below it differs more than these clips leave open. Maps of other clips agree less:
    resamples share most clips, and the classifiers are not trained again (`UtilityMap.reliability`).
    """
    samples = usual.mean_samples
    agreement = rank_agreement(usual.mean, usual.mean, samples, samples, resamples=100, seed=seed)
    return agreement.low, agreement.high


def _same_clips(first: UtilityMap, second: UtilityMap) -> bool:
    """Whether two maps were tested on the same clips of the same activities, however many windows each."""
    if first.activities != second.activities or len(first.mean_samples) != len(second.mean_samples):
        return False
    units = [
        np.unique(np.char.add(np.char.add(u.clip.astype(str), "/"), u.truth.astype(str)))
        for u in (first, second)
    ]
    return np.array_equal(*units)
