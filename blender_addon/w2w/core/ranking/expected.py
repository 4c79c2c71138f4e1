# SPDX-License-Identifier: GPL-3.0-or-later
"""Expected F1 on other clips: a map pooled, shrunk to what repeats, with honest intervals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
import scipy

from .halves import Plan, maps_of
from .pooling import UNLEARNED, Pooling, centred
from .weights import mean_over

UNPROVEN = 0.5
"""Share of a map's contrast, and of a set's gain, that is believed where the clips cannot be halved."""

FLATTEST, STEEPEST = 0.02, 1.0
"""Least F1 by unit of the pooled map, so that patches keep their order, and most: F1 is only ever shrunk."""

WANTED = 0.85
"""Reliability at which a map may be read patch by patch."""

HALF = 0.5
"""Reliability below which less than half of a map's contrast repeats on other clips."""

SURE, LIKELY = 0.9, 0.65
"""Chances of beating the average patch from which on clips rank placements, and hardly rank them."""

LEADERS = 20
"""The best 1 in 20 patches are the leaders of a map."""

TAIL = 0.975
"""Quantile by which errors are widened where few people tell of them."""

Pairs = Sequence[tuple[np.ndarray, np.ndarray]]
"""Maps (A, N), or their means (N,), of the one half of the clips and the other, halving by halving."""


@dataclass(frozen=True, eq=False)
class Expected:
    """F1 as other clips, or other people, would show it."""

    expected_f1: np.ndarray  # (N, A), float32
    expected_mean: np.ndarray  # (N,), float32: macro F1
    expected_low: np.ndarray  # (N,): its interval, in which the clips trained on vary too
    expected_high: np.ndarray
    reliability: float  # correlation over patches with as many other clips; NaN if clips cannot be halved
    beats_average: float  # chance that the best by the mean scores above the average patch on other clips
    errors: np.ndarray  # (E, N), float32: of the mean against as many other clips', but for the level


def expect(
    f1: np.ndarray, plan: Plan, pooling: Pooling, level: float, weights: np.ndarray | None = None
) -> Expected:
    """Expected scores of all patches from the F1 of all clips and of disjoint halves of them.

    F1 is averaged over a little skin, and over both sides as far as halves of the clips disagree about the
    side. A contrast that both halves show is signal, the rest is noise; their ratio decides how far to shrink
    and how wide the intervals are.

    `f1` (trials, A, N) is that of each trial of the plan, NaN where an activity was not tested. `weights`
    (A,) say what each activity counts in the macro F1, 1 each by default. `level` is the confidence of the
    intervals.
    """
    raw = np.nanmean(f1[: 1 + len(plan.repeats)], axis=0)
    weights = np.ones(len(raw)) if weights is None else weights
    repeat = _repeat(raw, f1, plan, pooling, weights)
    pooled = centred(pooling.apply(raw, repeat.side_share))
    by_activity = raw.mean(axis=1, keepdims=True) + repeat.slope_by_activity * pooled
    contrast = np.average(repeat.slopes[:, None] * pooled, axis=0, weights=weights)
    mean = mean_over(raw, weights, 0).mean() + contrast
    # two or three subjects tell little of how far people differ
    freedom = repeat.freedom if plan.disjoint else max(len(plan.whole.splits) - 1, 1)
    reach = scipy.special.stdtrit(freedom, (1 + level) / 2) * np.sqrt(repeat.variance)
    lead = float(mean.max() - mean.mean())
    chance = float(lead > 0)
    if repeat.of_lead > 0:
        chance = float(scipy.special.ndtr(lead / np.sqrt(repeat.of_lead)))
    return Expected(
        expected_f1=np.clip(by_activity, 0, 1).T.astype(np.float32),
        expected_mean=np.clip(mean, 0, 1).astype(np.float32),
        expected_low=np.maximum(mean - reach, 0).astype(np.float32),
        expected_high=np.minimum(mean + reach, 1).astype(np.float32),
        reliability=repeat.reliability,
        beats_average=chance,
        errors=repeat.errors.astype(np.float32),
    )


def most_shown(clip: np.ndarray, level: float) -> float:
    """Highest lower bound of F1 that so many clips, all recognised, could show: an exact binomial one."""
    return float(((1 - level) / 2) ** (1 / len(np.unique(clip))))


@dataclass(frozen=True, eq=False)
class _Repeat:
    """Repeatability of maps."""

    side_share: float  # for `Pooling.apply`
    slopes: np.ndarray  # (A,): share of each activity's pooled map that other clips' macro F1 shows
    slope_by_activity: float
    variance: float  # of a patch's expected macro F1
    freedom: float  # its degrees of freedom; infinite where it is known
    of_lead: float  # variance of the best patch's lead over the average one, about the expected
    errors: np.ndarray  # (2 pairs, N): errors of the expected map; no rows without halves
    reliability: float  # of the macro F1 of all clips; NaN without halves


def _repeat(whole: np.ndarray, f1: np.ndarray, plan: Plan, pooling: Pooling, weights: np.ndarray) -> _Repeat:
    shown = [first.testable & second.testable for first, second in plan.pairs]
    both = np.logical_and.reduce(shown) if shown else np.zeros(len(weights), dtype=bool)
    if not (both & (weights > 0)).any():
        # half of the map's contrast is believed, and nothing is known of its noise
        slopes, no_maps = np.full(len(weights), UNPROVEN), np.empty((0, f1.shape[2]))
        return _Repeat(UNLEARNED, slopes, UNPROVEN, 1.0, np.inf, np.inf, no_maps, np.nan)
    raw = [(a[both], b[both]) for a, b in maps_of(f1, plan)]
    side_share = pooling.side_share(raw) if plan.disjoint else UNLEARNED
    pooled = [(pooling.apply(a, side_share), pooling.apply(b, side_share)) for a, b in raw]
    raw_means, pooled_means = (
        [(mean_over(a, weights[both], 0), mean_over(b, weights[both], 0)) for a, b in pairs]
        for pairs in (raw, pooled)
    )
    slope = _slope(pooled_means, raw_means, plan.disjoint)
    rest = Unhalved.of(weights, both, plan.clips)
    slope_of_rest, of_rest = rest.repeat(centred(pooling.apply(whole[rest.rows], side_share)), pooled, raw)
    slope_of_rest = min(slope_of_rest, slope.of_all)
    noise_ratio = _noise_ratio(whole[both], raw, plan.clips[both], weights[both]) if plan.disjoint else 1.0
    halved = _variance(raw_means, pooled_means, slope, noise_ratio, plan.shrink)
    variance = rest.halved**2 * (halved.of_level + halved.of_patch) + rest.noise(raw)
    voters = len(np.unique(plan.vote[plan.vote >= 0]))
    compared = min(len(raw), voters - 1)  # halvings of few share people
    of_level = rest.halved**2 * halved.of_level
    # few people tell little of how far people differ
    normal, few = scipy.special.ndtri(TAIL), scipy.special.stdtrit(2 * max(voters - 1, 1), TAIL)
    errors = rest.halved * halved.errors * few / normal
    if of_rest > 0:
        errors *= np.sqrt(1 + of_rest / np.square(errors).mean())
    return _Repeat(
        side_share=side_share,
        slopes=np.where(both, slope.of_all, slope_of_rest),
        slope_by_activity=_slope(pooled, raw, plan.disjoint).of_all,
        variance=variance,
        # its level rests on few comparisons, the rest on many patches (Satterthwaite 1946,
        # doi:10.2307/3002019)
        freedom=compared * (variance / of_level) ** 2 if of_level > 0 else np.inf,
        of_lead=rest.halved**2 * halved.of_lead + of_rest,
        errors=errors,
        reliability=of_all(agreement(raw_means)) if plan.disjoint else np.nan,
    )


class _Slope(NamedTuple):
    """F1 by unit of a pooled map: of the other half by one half's, and how much steeper by all clips'."""

    of_half: float
    spearman_brown: float

    @property
    def of_all(self) -> float:
        """By the map of all clips, which repeats better than those of halves."""
        return self.of_half * self.spearman_brown


def _slope(pooled: Pairs, raw: Pairs, disjoint: bool) -> _Slope:
    """Least squares of the one half's F1 on the other half's pooled map, about means over patches."""
    together = square = repeated = 0.0
    for (a, b), (raw_a, raw_b) in zip(pooled, raw, strict=True):
        a, b = centred(a), centred(b)
        together += (a * centred(raw_b)).sum() + (b * centred(raw_a)).sum()
        square += (a**2).sum() + (b**2).sum()
        repeated += (a * b).sum()
    if square <= 0:
        return _Slope(0.0, 1.0)
    of_half = float(np.clip(together / square, FLATTEST, STEEPEST))
    # twice the clips have half the noise (Spearman 1910, Brown 1910)
    return _Slope(of_half, float(2 / (1 + np.clip(repeated / (square / 2), 0, 1))) if disjoint else 1.0)


def _noise_ratio(whole: np.ndarray, halves: Pairs, clips: np.ndarray, weights: np.ndarray) -> float:
    """Variance of F1 on all clips by half of that on halves of them.

    A share p of n clips varies by p (1 - p) / n; where more clips bring F1 nearer to 1, its noise falls by
    more than half. Fewer errors than half a clip count as half a clip.
    """
    f1_of_halves = np.mean([half.mean(axis=1) for pair in halves for half in pair], axis=0)
    means = ((whole.mean(axis=1), clips), (f1_of_halves, clips / 2))
    shares = (np.minimum(f1, 1 - 0.5 / count) for f1, count in means)
    of_whole, of_half = ((weights**2 * p * (1 - p)).sum() for p in shares)
    return max(float(of_whole / of_half), 0.0) if of_half > 0 else 1.0


class _Variance(NamedTuple):
    """Variances of macro F1 about its expectation."""

    of_level: float  # of the level that all patches share
    of_patch: float  # of one patch beyond that: what pooling left out of the signal, and noise
    of_lead: float  # of a leader's lead over the average patch, as one half shows it and the other expects
    errors: np.ndarray  # (2 pairs, N): what one half shows less what the other expects, about the mean


def _variance(raw: Pairs, pooled: Pairs, slope: _Slope, noise_ratio: float, shrink: float) -> _Variance:
    """Variances from the halves' macro F1 (N,), raw and pooled.

    The variance of a patch is half of that between its F1 on other clips and its expected F1; the other half
    is the noise of those other clips.
    """
    scale = noise_ratio / shrink
    of_level = np.mean([(a.mean() - b.mean()) ** 2 for a, b in raw]) * scale
    noise = np.mean([np.var(a - b) for a, b in raw]) * scale
    signal = np.mean([(centred(a) * centred(b)).mean() for a, b in raw])
    pooled_variance = np.mean([np.var(half) for pair in pooled for half in pair])
    explained = float(slope.spearman_brown * slope.of_half**2 * pooled_variance)
    errors, of_leaders = [], []
    for (raw_a, raw_b), (a, b) in zip(raw, pooled, strict=True):
        for here, there in ((a, raw_b), (b, raw_a)):
            errors.append((centred(there) - slope.of_half * centred(here)) * np.sqrt(2 * scale))
            best = np.argsort(-here, kind="stable")[: max(len(here) // LEADERS, 1)]
            of_leaders.append(np.square(errors[-1][best]).mean())
    of_patch = float((max(signal - explained, 0.0) + noise) / 2)
    return _Variance(float(of_level), of_patch, float(np.mean(of_leaders)), np.array(errors))


@dataclass(frozen=True, eq=False)
class Unhalved:
    """The R activities with too few clips to be halved.

    Two or three clips of an activity count in the mean like forty of another, but no halves show how far
    their map repeats. Halves of the H others show the noise of a clip.
    """

    rows: np.ndarray  # (A,), bool: which activities they are
    halved: float  # what the others count in the macro F1, of 1
    shares: np.ndarray  # (R,): what each of these counts in it
    clips: np.ndarray  # (R,): how many clips it has
    clips_of_halved: np.ndarray  # (H,)

    @classmethod
    def of(cls, weights: np.ndarray, both: np.ndarray, clips: np.ndarray) -> Self:
        """Select them by the weight of each activity (A,), whether both halves show it, and its clips."""
        rows = ~both & (weights > 0)
        shares = weights / weights.sum()
        return cls(rows, float(shares[both].sum()), shares[rows], clips[rows], clips[both])

    def noise(self, halves: Pairs) -> float:
        """Variance of their part of a patch's macro F1, from maps of the others' halves (H, N)."""
        of_a_clip = np.array([((a - b) ** 2).mean(axis=1) for a, b in halves]) / 2 * self.clips_of_halved / 2
        return float((self.shares**2 / self.clips).sum() * of_a_clip.mean())

    def repeat(self, pooled: np.ndarray, pooled_halves: Pairs, raw_halves: Pairs) -> tuple[float, float]:
        """What share of their contrast repeats, and the variance with which other clips show it.

        `pooled` (R, N) are their own maps: contrast beyond the noise of so few clips is signal. The variance
        is that of the noise in these maps and in those of as many other clips.
        """
        contrast = float(np.var(self.shares @ pooled))
        noise = self.noise([(centred(a), centred(b)) for a, b in pooled_halves])
        share = max(contrast - noise, 0.0) / contrast if contrast > 0 else 0.0
        of_others = self.noise([(centred(a), centred(b)) for a, b in raw_halves])
        return share, min(contrast, noise) + of_others


def agreement(pairs: Pairs) -> float:
    """Mean correlation over patches of the maps (N,) of each pair; 0 for a flat map."""
    correlations = [np.corrcoef(a, b)[0, 1] if np.ptp(a) > 0 and np.ptp(b) > 0 else 0.0 for a, b in pairs]
    return float(np.mean(correlations)) if correlations else np.nan


def of_all(of_halves: float) -> float:
    """Reliability of the map of all clips from the agreement of halves of them (Spearman 1910, Brown 1910).

    A negative agreement stays as it is: no number of clips makes a map of it.
    """
    return 2 * of_halves / (1 + of_halves) if of_halves > 0 else of_halves


def clips_needed(reliability: float) -> float:
    """Factor on the number of clips that would give the reliability `WANTED`, by the same formula.

    1 or less if these are enough; infinite if they show nothing that repeats; NaN if that is not known.
    """
    if reliability <= 0:
        return np.inf
    return WANTED * (1 - reliability) / (reliability * (1 - WANTED))
