# SPDX-License-Identifier: GPL-3.0-or-later
"""Rank correlation of two rankings of the same patches or sites, its interval and its chance."""

from dataclasses import dataclass

import numpy as np
import scipy


@dataclass(frozen=True)
class Agreement:
    """Agreement of two scores about the order of the same patches or sites.

    Attributes
    ----------
    spearman, kendall : float
        Spearman's rho and Kendall's tau-b; NaN where all score the same.
    low, high : float
        Interval of rho (`bootstrap_interval`).
    p_value : float
        Chance of a rho this high or higher if their order meant nothing. It
        takes them as exchangeable; neighbouring patches of a body are not, so over
        many patches it is far too small, and the interval is what to read.
    n_ranked : int
        How many patches or sites.
    """

    spearman: float
    kendall: float
    low: float
    high: float
    p_value: float
    n_ranked: int

    @property
    def step(self) -> float:
        """Loss of rho by one swap of neighbours in the order: 12 / (n (n^2 - 1))."""
        return 12.0 / (self.n_ranked * (self.n_ranked**2 - 1))


def rank_agreement(
    first: np.ndarray,
    second: np.ndarray,
    first_samples: np.ndarray | None = None,
    second_samples: np.ndarray | None = None,
    resamples: int = 2000,
    level: float = 0.95,
    seed: int = 0,
) -> Agreement:
    """Compare two scores of the same patches or sites.

    Parameters
    ----------
    first, second : array_like, shape (N,)
        Scores, such as F1 of one activity at each patch, N >= 3.
    first_samples, second_samples : ndarray, shape (B, N), optional
        Bootstrap resamples of the scores, such as `UtilityMap.mean_samples`. With either
        of them the interval says how rho varies with the clips tested; with neither the
        patches themselves are resampled, which says how it varies with those compared.
    resamples : int
        Resamples of the patches, and random pairings for the p-value where not all
        pairings are tried (up to 7 patches they are).
    level : float
        Confidence of the interval.
    seed : int

    Returns
    -------
    Agreement

    Raises
    ------
    ValueError
        If the scores are not two lists of equal length, or of fewer than three.

    Examples
    --------
    >>> w2w.rank_agreement([1, 2, 3, 4], [1, 2, 4, 3]).spearman
    0.8
    """
    first, second = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if first.ndim != 1 or first.shape != second.shape:
        raise ValueError(
            f"the two scores must be of the same patches or sites, not {first.shape} and {second.shape}"
        )
    if len(first) < 3:
        raise ValueError(
            f"a ranking of {len(first)} patches or sites cannot agree or disagree; three are needed"
        )
    rng = np.random.default_rng(seed)
    rho = float(spearman_rows(first, second))
    if np.isnan(rho):
        return Agreement(np.nan, np.nan, np.nan, np.nan, np.nan, len(first))
    if first_samples is None and second_samples is None:
        drawn = rng.integers(len(first), size=(resamples, len(first)))
        spread = spearman_rows(first[drawn], second[drawn])
    else:
        spread = spearman_rows(
            *np.broadcast_arrays(
                first[None] if first_samples is None else first_samples,
                second[None] if second_samples is None else rng.permutation(second_samples),
            )
        )
    low, high = bootstrap_interval(rho, spread, level)
    chance = scipy.stats.permutation_test(
        (first,),
        lambda paired, axis: spearman_rows(np.moveaxis(paired, axis, -1), second),
        permutation_type="pairings",
        alternative="greater",
        n_resamples=max(resamples, 5040),
        vectorized=True,
        batch=1000,
        random_state=rng,
    )
    tau = float(scipy.stats.kendalltau(first, second).statistic)
    return Agreement(rho, tau, low, high, float(chance.pvalue), len(first))


def bootstrap_interval(estimate: float, draws: np.ndarray, level: float = 0.95) -> tuple[float, float]:
    """Interval of a statistic that resampling shifts, such as a rank correlation.

    Resampling adds noise to noise, so the draws agree less than the estimate does. The
    bias-corrected interval undoes that but is too narrow over few sites, and so is BCa;
    this one spans it, the percentile interval and the estimate, and holds the truth most
    often (docs/evidence/people.md).

    Parameters
    ----------
    estimate : float
    draws : ndarray, shape (B,)
        The statistic of each resample; NaN where it has none.
    level : float
        Confidence of the interval.

    Returns
    -------
    low, high : float
        NaN if there is no estimate or no draw.

    References
    ----------
    Efron, "Better bootstrap confidence intervals", JASA 1987 (doi:10.2307/2289144).
    """
    draws = draws[np.isfinite(draws)]
    if not len(draws) or np.isnan(estimate):
        return np.nan, np.nan
    tails = np.array([(1 - level) / 2, (1 + level) / 2])
    below = ((draws < estimate).mean() + (draws <= estimate).mean()) / 2
    shift = scipy.stats.norm.ppf(np.clip(below, 0.5 / len(draws), 1 - 0.5 / len(draws)))
    corrected = scipy.stats.norm.cdf(2 * shift + scipy.stats.norm.ppf(tails))
    bounds = [estimate, *np.quantile(draws, [*tails, *corrected])]
    return float(min(bounds)), float(max(bounds))


def spearman_rows(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Spearman's rho (B,) of each row of `first` (B, N) with that of `second`; NaN if a row is constant."""
    ranks = [scipy.stats.rankdata(rows, axis=-1) for rows in (first, second)]
    a, b = (rank - rank.mean(axis=-1, keepdims=True) for rank in ranks)
    with np.errstate(invalid="ignore"):
        return (a * b).sum(axis=-1) / np.sqrt((a * a).sum(axis=-1) * (b * b).sum(axis=-1))
