# SPDX-License-Identifier: GPL-3.0-or-later
"""What a patch would score on other clips: its map pooled, shrunk to what repeats, with honest intervals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.stats import t

from .halves import Plan, maps_of
from .pooling import Pooling, centred
from .reliability import agreement, of_all, with_noise
from .unhalved import Unhalved
from .weights import alike, mean_over

UNPROVEN = 0.5
"""Share of a map's contrast, and of a set's gain, that is believed where the clips cannot be halved."""

FLATTEST, STEEPEST = 0.02, 20.0
"""Least F1 by unit of the map's score, so that patches keep their order, and most, as its range is narrow."""

DRAWS = 1000
"""Maps of noise from which it is judged which patches are as good as the best."""


@dataclass(frozen=True, eq=False)
class Expected:
    """F1 as other clips, or other people, would show it.

    Attributes
    ----------
    f1 : ndarray, shape (N, A)
    mean, low, high : ndarray, shape (N,)
        Macro F1 and its interval, in which the clips trained on vary too.
    as_good : ndarray of bool, shape (N,)
        Patches that cannot be told from the one of highest `mean`, the choice among all N accounted for.
    can_rank : bool
        Whether halves of the clips agree about the patches more than noise would have them.
    reliability : float
        Correlation over patches that the map would have with that of as many other clips; NaN where
        these cannot be halved.
    """

    f1: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    as_good: np.ndarray
    can_rank: bool
    reliability: float


@dataclass(frozen=True, eq=False)
class TrialMaps:
    """Maps of each trial of a plan.

    Attributes
    ----------
    score, raw : ndarray, shape (trials, A, N)
        What patches are compared by (`map_scores.rank_score`), and F1 by window; NaN where an activity
        was not tested.
    """

    score: np.ndarray
    raw: np.ndarray


def expect(
    maps: TrialMaps,
    plan: Plan,
    pooling: Pooling,
    level: float,
    seed: int,
    weights: np.ndarray | None = None,
) -> Expected:
    """Expected scores of all patches from the maps of all clips and of disjoint halves of them.

    What one half shows and the other shows again is signal; what it does not is noise. From that
    follow how far sides are pooled, how far to shrink, and how sure the result is.

    Parameters
    ----------
    maps : TrialMaps
    plan : Plan
    pooling : Pooling
    level : float
        Confidence of the intervals and of `as_good`.
    seed : int
        Of the draws of noise.
    weights : ndarray, shape (A,), optional
        What each activity counts in the macro F1; all alike by default.
    """
    raw = maps.raw[0]
    weights = np.ones(len(raw)) if weights is None else weights
    repeat = _Repeat.of(maps, plan, pooling, weights, seed)
    pooled = pooling.apply(maps.score[0], repeat.shares)
    f1 = raw.mean(axis=1, keepdims=True) + repeat.slope_by_activity * centred(pooled)
    level_of_all = raw.mean() if alike(weights) else mean_over(raw, weights, 0).mean()
    mean = level_of_all + repeat.slope * centred(mean_over(pooled, weights, 0))
    # two or three subjects tell little of how far people differ
    freedom = repeat.freedom if plan.disjoint else max(len(plan.whole.splits) - 1, 1)
    reach = t(freedom).ppf((1 + level) / 2) * np.sqrt(repeat.variance)
    return Expected(
        f1=np.clip(f1, 0, 1).T.astype(np.float32),
        mean=np.clip(mean, 0, 1).astype(np.float32),
        low=np.maximum(mean - reach, 0).astype(np.float32),
        high=np.minimum(mean + reach, 1).astype(np.float32),
        as_good=_as_good(mean, repeat.noise_maps, level, seed),
        can_rank=_agree(repeat, level),
        reliability=repeat.reliability,
    )


@dataclass(frozen=True, eq=False)
class _Repeat:
    """How far maps repeat.

    Attributes
    ----------
    shares : ndarray, shape (2, A)
        For `Pooling.apply`.
    slope, slope_by_activity : float
        F1 by unit of the pooled map, about its mean.
    variance : float
        Of a patch's expected macro F1.
    freedom : float
        Degrees of freedom of this variance; infinite where it is known.
    noise_maps : ndarray, shape (pairs, N)
        What the expected map of all clips might be off by; none where the clips cannot be halved.
    agreement : float
        Mean product of what the two of a pair say of a patch's lead, in the units of `noise_maps`.
    reliability : float
        Of the map of all clips; NaN where they cannot be halved.
    """

    shares: np.ndarray
    slope: float
    slope_by_activity: float
    variance: float
    freedom: float
    noise_maps: np.ndarray
    agreement: float
    reliability: float

    @classmethod
    def of(cls, maps: TrialMaps, plan: Plan, pooling: Pooling, weights: np.ndarray, seed: int) -> _Repeat:
        whole = maps.score[0]
        shown = [first.testable & second.testable for first, second in plan.pairs]
        both = np.logical_and.reduce(shown) if shown else np.zeros(len(whole), dtype=bool)
        if not (both & (weights > 0)).any():
            return cls._unproven(maps, pooling, weights)
        means_of = partial(_means_over, weights=weights[both])
        scores = [(a[both], b[both]) for a, b in maps_of(maps.score, plan)]
        raw = [(a[both], b[both]) for a, b in maps_of(maps.raw, plan)]
        shares = pooling.learn(scores if plan.disjoint else [], int(both.sum()))
        pooled = [(pooling.apply(a, shares), pooling.apply(b, shares)) for a, b in scores]
        slope, by_activity = _slope(means_of(pooled), means_of(raw)), _slope(pooled, raw)
        rest = Unhalved.of(weights, both, plan.clips)
        more = (_of_all(means_of(pooled)), _of_all(pooled)) if plan.disjoint else (1.0, 1.0)
        counted = (plan.clips[both], weights[both])
        left = _noise_left(maps.raw[0][both], raw, *counted) if plan.disjoint else 1.0
        kept = more[0] * slope**2 * np.mean([np.var(half) for pair in means_of(pooled) for half in pair])
        of_level, of_patch = _variances(means_of(raw), float(kept), left / plan.shrink)
        variance = rest.variance_with(of_level + of_patch, raw)
        freedom = _freedom(rest.halved**2 * of_level, len(raw), variance)
        slope, by_activity = slope * more[0], by_activity * more[1]
        every = np.repeat(shares.mean(axis=1, keepdims=True), len(whole), axis=1)
        every[:, both] = shares
        believed = rest.believed(pooling.apply(whole, every)[rest.rows], pooled)
        every[:, ~both] *= believed
        means = slope * rest.halved * centred(np.array(means_of(pooled)))
        of_rest = slope * rest.noise_maps(pooled, believed, seed)
        signal = float((means[:, 0] * means[:, 1]).mean())
        reliability = of_all(agreement(means_of(pooled))) if plan.disjoint else np.nan
        return cls(
            shares=every,
            slope=slope,
            slope_by_activity=by_activity,
            variance=variance,
            freedom=freedom,
            noise_maps=(means[:, 0] - means[:, 1]) / np.sqrt(plan.shrink) + of_rest,
            agreement=signal * 2 / plan.shrink,
            reliability=with_noise(reliability, signal, float(of_rest.var())),
        )

    @classmethod
    def _unproven(cls, maps: TrialMaps, pooling: Pooling, weights: np.ndarray) -> _Repeat:
        score, raw = maps.score[0], maps.raw[0]
        shares = pooling.learn([], len(score))
        pooled = pooling.apply(score, shares)
        slopes = [
            UNPROVEN * _slope([(one, one)], [(other, other)])
            for one, other in ((mean_over(pooled, weights, 0), mean_over(raw, weights, 0)), (pooled, raw))
        ]
        return cls(shares, *slopes, 1.0, np.inf, np.empty((0, raw.shape[1])), 0.0, np.nan)


def _of_all(pairs: list[tuple[np.ndarray, np.ndarray]]) -> float:
    """How much steeper a slope is for twice the clips, whose noise is half (Spearman 1910, Brown 1910)."""
    together = sum((centred(a) * centred(b)).sum() for a, b in pairs)
    square = sum((centred(a) ** 2).sum() + (centred(b) ** 2).sum() for a, b in pairs) / 2
    return float(2 / (1 + np.clip(together / square, 0, 1))) if square > 0 else 1.0


def _slope(seen: list[tuple[np.ndarray, np.ndarray]], other: list[tuple[np.ndarray, np.ndarray]]) -> float:
    """Least squares of the one half's F1 on the other half's pooled map, about means over patches."""
    together = square = 0.0
    for (a, b), (of_a, of_b) in zip(seen, other, strict=True):
        together += (centred(a) * centred(of_b)).sum() + (centred(b) * centred(of_a)).sum()
        square += (centred(a) ** 2).sum() + (centred(b) ** 2).sum()
    return float(np.clip(together / square, FLATTEST, STEEPEST)) if square > 0 else 0.0


def _noise_left(
    whole: np.ndarray, pairs: list[tuple[np.ndarray, np.ndarray]], clips: np.ndarray, weights: np.ndarray
) -> float:
    """Variance of F1 on all clips by half of that on halves of them.

    A share p of so many clips varies by p (1 - p) over their number; where more clips bring F1 nearer
    to 1, its noise falls by more than half. Fewer errors than half a clip count as half a clip.
    """
    halves = np.mean([half.mean(axis=1) for pair in pairs for half in pair], axis=0)
    shares = [np.minimum(f1, 1 - 0.5 / of) for f1, of in ((whole.mean(axis=1), clips), (halves, clips / 2))]
    of_all, of_half = ((weights**2 * f1 * (1 - f1)).sum() for f1 in shares)
    return float(of_all / of_half) if of_half > 0 else 1.0


def _variances(raw: list[tuple[np.ndarray, np.ndarray]], kept: float, shrunk: float) -> tuple[float, float]:
    """Variance of the expected macro F1 of a patch about its true one, in two parts.

    The level that all patches share, and half of what one patch's F1 on other clips lies off its
    expected F1 beyond that: what pooling left out, all but `kept` of the signal's variance, and the noise
    of that other F1.
    """
    of_level = np.mean([(a.mean() - b.mean()) ** 2 for a, b in raw]) * shrunk
    of_noise = np.mean([np.var(a - b) for a, b in raw]) * shrunk
    signal = np.mean([(centred(a) * centred(b)).mean() for a, b in raw])
    return float(of_level), float((max(signal - kept, 0.0) + of_noise) / 2)


def _freedom(of_level: float, pairs: int, variance: float) -> float:
    """Degrees of freedom of a variance whose part `of_level` few pairs tell, the rest many patches
    (Satterthwaite 1946, doi:10.2307/3002019)."""
    return pairs * (variance / of_level) ** 2 if of_level > 0 else np.inf


def _agree(repeat: _Repeat, level: float) -> bool:
    """Whether pairs agree more than noise alone would in a share `level` of libraries.

    How far two maps of noise agree by chance is told by how far the noise of one pair agrees with
    that of another; of a single pair, by its square, which is more.
    """
    noise = repeat.noise_maps
    if not len(noise):
        return False
    products = noise @ noise.T / noise.shape[1]
    others = products[np.triu_indices(len(noise), 1)] if len(noise) > 1 else np.diag(products)
    return bool(repeat.agreement > t.ppf(level, len(others)) * np.sqrt((others**2).mean()))


def _as_good(mean: np.ndarray, noise_maps: np.ndarray, level: float, seed: int) -> np.ndarray:
    """Patches that noise alone would leave so far behind the best of all more often than 1 - level.

    Each draw is a random sum of the noise maps (the multiplier bootstrap, van der Vaart and Wellner
    1996), and the best of all is sought in each: the choice is part of what varies.
    """
    if not len(noise_maps):
        return np.ones(len(mean), dtype=bool)
    draws = np.random.default_rng([seed, 3]).normal(size=(DRAWS, len(noise_maps)))
    noise = draws @ noise_maps / np.sqrt(len(noise_maps))
    furthest = np.quantile(noise.max(axis=1, keepdims=True) - noise, level, axis=0)
    return mean.max() - mean <= furthest + 1e-9


def _means_over(
    pairs: list[tuple[np.ndarray, np.ndarray]], weights: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(mean_over(a, weights, 0), mean_over(b, weights, 0)) for a, b in pairs]
