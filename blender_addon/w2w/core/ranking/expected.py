# SPDX-License-Identifier: GPL-3.0-or-later
"""What a patch would score on other clips: its map pooled, shrunk to what repeats, with honest intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, t

from .halves import Plan, maps_of
from .pooling import UNLEARNED, Pooling, centred
from .reliability import agreement, of_all
from .unhalved import Unhalved
from .weights import mean_over

UNPROVEN = 0.5
"""Share of a map's contrast, and of a set's gain, that is believed where the clips cannot be halved."""

FLATTEST, STEEPEST = 0.02, 1.0
"""Least F1 by unit of the pooled map, so that patches keep their order, and most: F1 is only ever shrunk."""

SURE = 0.9
"""Chance of beating the average patch from which on clips are said to rank placements."""

LEADERS = 20
"""One in so many patches counts as a leader of its map."""

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
        Whether the best patch is sure enough (`SURE`) to beat the average one, and some patch can be told
        from it.
    reliability : float
        Correlation over patches of the macro F1 itself with that on as many other clips; NaN where these
        cannot be halved.
    beats_average : float
        Chance that the patch of highest `mean` scores above the average patch on as many other clips.
    """

    f1: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    as_good: np.ndarray
    can_rank: bool
    reliability: float
    beats_average: float


def expect(
    f1: np.ndarray,
    plan: Plan,
    pooling: Pooling,
    level: float,
    seed: int,
    weights: np.ndarray | None = None,
) -> Expected:
    """Expected scores of all patches from the F1 of all clips and of disjoint halves of them.

    F1 is averaged over a little skin, and over both sides as far as halves of the clips disagree about the
    side; what one half shows and the other shows again is signal, what it does not is noise. From that follow
    how far to shrink, and how sure the result is.

    Parameters
    ----------
    f1 : ndarray, shape (trials, A, N)
        F1 by window of each trial of the plan; NaN where an activity was not tested.
    plan : Plan
    pooling : Pooling
    level : float
        Confidence of the intervals and of `as_good`.
    seed : int
        Of the draws of noise.
    weights : ndarray, shape (A,), optional
        What each activity counts in the macro F1; all alike by default.
    """
    raw = f1[0]
    weights = np.ones(len(raw)) if weights is None else weights
    repeat = _repeat(f1, plan, pooling, weights, seed)
    pooled = centred(pooling.apply(raw, repeat.side_share))
    by_activity = raw.mean(axis=1, keepdims=True) + repeat.slope_by_activity * pooled
    mean = mean_over(raw, weights, 0).mean() + repeat.slope * mean_over(pooled, weights, 0)
    # two or three subjects tell little of how far people differ
    freedom = repeat.freedom if plan.disjoint else max(len(plan.whole.splits) - 1, 1)
    reach = t(freedom).ppf((1 + level) / 2) * np.sqrt(repeat.variance)
    as_good = _as_good(mean, repeat.noise_maps, level, seed)
    chance = _beats_average(mean, repeat.of_lead)
    return Expected(
        f1=np.clip(by_activity, 0, 1).T.astype(np.float32),
        mean=np.clip(mean, 0, 1).astype(np.float32),
        low=np.maximum(mean - reach, 0).astype(np.float32),
        high=np.minimum(mean + reach, 1).astype(np.float32),
        as_good=as_good,
        can_rank=chance >= SURE and not as_good.all(),
        reliability=repeat.reliability,
        beats_average=chance,
    )


@dataclass(frozen=True, eq=False)
class _Repeat:
    """How far maps repeat.

    Attributes
    ----------
    side_share : float
        For `Pooling.apply`.
    slope, slope_by_activity : float
        F1 on other clips by unit of the pooled map, about its mean.
    variance : float
        Of a patch's expected macro F1.
    freedom : float
        Degrees of freedom of this variance; infinite where it is known.
    of_lead : float
        Variance of a chosen patch's lead over the average one on as many other clips, about what is expected.
    noise_maps : ndarray, shape (pairs, N)
        What the expected map of all clips might be off by; none where the clips cannot be halved.
    reliability : float
        Of the macro F1 of all clips; NaN where they cannot be halved.
    """

    side_share: float
    slope: float
    slope_by_activity: float
    variance: float
    freedom: float
    of_lead: float
    noise_maps: np.ndarray
    reliability: float


def _repeat(f1: np.ndarray, plan: Plan, pooling: Pooling, weights: np.ndarray, seed: int) -> _Repeat:
    shown = [first.testable & second.testable for first, second in plan.pairs]
    both = np.logical_and.reduce(shown) if shown else np.zeros(len(weights), dtype=bool)
    if not (both & (weights > 0)).any():
        return _unproven(f1.shape[2])
    raw = [(a[both], b[both]) for a, b in maps_of(f1, plan)]
    side_share = pooling.side_share(raw) if plan.disjoint else UNLEARNED
    pooled = [(pooling.apply(a, side_share), pooling.apply(b, side_share)) for a, b in raw]
    raw_means, pooled_means = (_means_over(pairs, weights[both]) for pairs in (raw, pooled))
    slope, by_activity = _slope(pooled_means, raw_means), _slope(pooled, raw)
    # the map of all clips repeats better than those of halves
    rise, rise_by_activity = (
        (_spearman_brown(pooled_means), _spearman_brown(pooled)) if plan.disjoint else (1, 1)
    )

    rest = Unhalved.of(weights, both, plan.clips)
    of_rest = slope * rise * rest.noise_maps(pooled, seed)

    noise_ratio = _noise_ratio(f1[0][both], raw, plan.clips[both], weights[both]) if plan.disjoint else 1.0
    explained = rise * slope**2 * np.mean([np.var(half) for pair in pooled_means for half in pair])
    of_level, of_patch = _variances(raw_means, float(explained), noise_ratio / plan.shrink)
    variance = rest.variance_with(of_level + of_patch, raw)
    of_lead = _lead_variance(raw_means, pooled_means, slope) * 2 * noise_ratio / plan.shrink
    leads = slope * rise * rest.halved * centred(np.array(pooled_means))
    told = min(len(raw), len(np.unique(plan.vote[plan.vote >= 0])) - 1)  # halvings of few share people
    return _Repeat(
        side_share=side_share,
        slope=slope * rise,
        slope_by_activity=by_activity * rise_by_activity,
        variance=variance,
        freedom=_freedom(rest.halved**2 * of_level, told, variance),
        of_lead=rest.halved**2 * of_lead + float(of_rest.var()),
        noise_maps=(leads[:, 0] - leads[:, 1]) / np.sqrt(plan.shrink) + of_rest,
        reliability=of_all(agreement(raw_means)) if plan.disjoint else np.nan,
    )


def _unproven(n_patches: int) -> _Repeat:
    """Clips that cannot be halved: half of the map's contrast is believed, and nothing is known of noise."""
    return _Repeat(
        side_share=UNLEARNED,
        slope=UNPROVEN,
        slope_by_activity=UNPROVEN,
        variance=1.0,
        freedom=np.inf,
        of_lead=np.inf,
        noise_maps=np.empty((0, n_patches)),
        reliability=np.nan,
    )


def _spearman_brown(pairs: list[tuple[np.ndarray, np.ndarray]]) -> float:
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


def _noise_ratio(
    whole: np.ndarray, pairs: list[tuple[np.ndarray, np.ndarray]], clips: np.ndarray, weights: np.ndarray
) -> float:
    """Variance of F1 on all clips by half of that on halves of them.

    A share p of so many clips varies by p (1 - p) over their number; where more clips bring F1 nearer
    to 1, its noise falls by more than half. Fewer errors than half a clip count as half a clip.
    """
    halves = np.mean([half.mean(axis=1) for pair in pairs for half in pair], axis=0)
    shares = [np.minimum(f1, 1 - 0.5 / of) for f1, of in ((whole.mean(axis=1), clips), (halves, clips / 2))]
    of_all, of_half = ((weights**2 * f1 * (1 - f1)).sum() for f1 in shares)
    return max(float(of_all / of_half), 0.0) if of_half > 0 else 1.0


def _variances(
    raw: list[tuple[np.ndarray, np.ndarray]], explained: float, shrunk: float
) -> tuple[float, float]:
    """Variance of the expected macro F1 of a patch about its true one, in two parts.

    The level that all patches share, and half of what one patch's F1 on other clips lies off its
    expected F1 beyond that: the signal's variance that pooling left out (all but `explained`), and the noise
    of that other F1.
    """
    of_level = np.mean([(a.mean() - b.mean()) ** 2 for a, b in raw]) * shrunk
    of_noise = np.mean([np.var(a - b) for a, b in raw]) * shrunk
    signal = np.mean([(centred(a) * centred(b)).mean() for a, b in raw])
    return float(of_level), float((max(signal - explained, 0.0) + of_noise) / 2)


def _lead_variance(
    raw: list[tuple[np.ndarray, np.ndarray]], pooled: list[tuple[np.ndarray, np.ndarray]], slope: float
) -> float:
    """How far the leads of one half's best patches lie off what the other half shows, squared, on average."""
    missed = []
    for (a, b), (of_a, of_b) in zip(raw, pooled, strict=True):
        for here, there in ((of_a, b), (of_b, a)):
            best = np.argsort(-here, kind="stable")[: max(len(here) // LEADERS, 1)]
            missed.append((centred(there) - slope * centred(here))[best])
    return float(np.square(missed).mean())


def _freedom(of_level: float, told: int, variance: float) -> float:
    """Degrees of freedom of a variance whose part `of_level` so few tell, the rest many patches
    (Satterthwaite 1946, doi:10.2307/3002019)."""
    return told * (variance / of_level) ** 2 if of_level > 0 else np.inf


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


def _beats_average(mean: np.ndarray, variance: float) -> float:
    """Chance that the best patch's lead over the average one is above zero, told with this variance."""
    lead = float(mean.max() - mean.mean())
    return float(norm.cdf(lead / np.sqrt(variance))) if variance > 0 else float(lead > 0)


def _means_over(
    pairs: list[tuple[np.ndarray, np.ndarray]], weights: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(mean_over(a, weights, 0), mean_over(b, weights, 0)) for a, b in pairs]
