# SPDX-License-Identifier: GPL-3.0-or-later
"""Do simulated sensors rank sites as real ones do: F1 by site and activity on both sides, and agreement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..imu.recording import ImuRecording
from ..ranking.agreement import Agreement, rank_agreement, spearman_rows
from ..ranking.f1 import count_by_clip, f1_scores, resampled_f1
from ..ranking.features import window_features
from ..ranking.utility import UtilityMap, utility_map
from ..ranking.windows import TooShortError, WindowSpec, cut_windows

RESAMPLES = 2000
HALVINGS = 200


class SiteWindows(NamedTuple):
    """Windows of sensors at the same sites, as features.

    Attributes
    ----------
    features : ndarray, shape (W, N, D)
    activity, clip, subject : ndarray of str, shape (W,)
        Subjects are empty where unknown.
    is_test : ndarray of bool, shape (W,)
    skipped : dict of str to str
        Clips too short or too full of gaps, each with the reason.
    """

    features: np.ndarray
    activity: np.ndarray
    clip: np.ndarray
    subject: np.ndarray
    is_test: np.ndarray
    skipped: dict[str, str]


@dataclass(frozen=True)
class SiteValidation:
    """Agreement of two maps of the same sites.

    Parameters
    ----------
    sites : tuple of str
    real, simulated : UtilityMap
    by_activity : dict of str to Agreement
        NaN where one side cannot tell its sites apart.
    overall : Agreement
        Of macro F1.
    mean_rho, mean_low, mean_high : float
        Mean of the activities' rho, and its bootstrap interval over clips.
    mean_p : float
        Chance of a mean this high if the simulated sites were called by each other's names.
    ceiling : float
        Mean rho between the rankings of two random halves of the real clips: nothing simulated
        can be expected to agree better with the whole than about this.
    """

    sites: tuple[str, ...]
    real: UtilityMap
    simulated: UtilityMap
    by_activity: dict[str, Agreement]
    overall: Agreement
    mean_rho: float
    mean_low: float
    mean_high: float
    mean_p: float
    ceiling: float

    def sentence(self, target: float = 0.85) -> str:
        """What was found, with how coarse it is."""
        defined = [name for name, found in self.by_activity.items() if np.isfinite(found.spearman)]
        reached = "reaches" if self.mean_rho >= target else "is below"
        n = len(self.sites)
        return (
            f"Over {len(defined)} activities and {n} sites the mean Spearman rho between real and simulated "
            f"rankings is {self.mean_rho:.2f} (95 % interval {self.mean_low:.2f} to {self.mean_high:.2f}, "
            f"p = {self.mean_p:.3f}), which {reached} {target:g}; rankings from two halves of the real clips "
            f"agree at {self.ceiling:.2f}, and with {n} sites one swap of neighbours costs an activity's rho "
            f"{self.overall.step:.2f}."
        )


def site_windows(
    recordings: Sequence[ImuRecording], spec: WindowSpec, rates_only: bool = False
) -> SiteWindows:
    """Cut recordings of the same sites and rate into windows and describe these.

    Parameters
    ----------
    recordings : sequence of ImuRecording
        Each a clip with its labels.
    spec : WindowSpec
    rates_only : bool
        Take no notice of accelerations, for sensors that have none.

    Raises
    ------
    ValueError
        If no recording gives a window, or sites or rates differ.
    """
    if len({(recording.sites, recording.rate) for recording in recordings}) != 1:
        raise ValueError("recordings to be compared must share their sites and their rate")
    features, labels, is_test, skipped = [], [], [], {}
    for recording in recordings:
        taken = replace(recording, acc=np.zeros_like(recording.acc)) if rates_only else recording
        try:
            windows = cut_windows(taken, spec)
        except TooShortError as error:
            skipped[recording.clip] = str(error)
            continue
        features.append(window_features(windows.signals, recording.rate))
        is_test.append(windows.is_test)
        labels += [(recording.activity, recording.clip, recording.subject)] * len(windows.is_test)
    if not features:
        raise ValueError(f"no clip gives a window: {next(iter(skipped.values()))}")
    activity, clip, subject = np.array(labels).T
    return SiteWindows(np.concatenate(features), activity, clip, subject, np.concatenate(is_test), skipped)


def validate_sites(
    real: SiteWindows,
    simulated: SiteWindows,
    sites: Sequence[str],
    activities: Sequence[str],
    folds: int = 5,
    by_subject: tuple[bool, bool] = (False, False),
    seed: int = 0,
) -> SiteValidation:
    """Train and test each site on real windows, then on simulated ones, and compare the rankings.

    Parameters
    ----------
    real, simulated : SiteWindows
        Of the same sites. Where both hold the same clips, both are dealt to the same folds.
    sites : sequence of str
    activities : sequence of str
        Only those that can be tested on both sides are.
    folds : int
    by_subject : (bool, bool)
        Leave one subject out at a time, on the real and on the simulated side.
    seed : int

    Raises
    ------
    ValueError
        If fewer than two activities can be tested on both sides, or there are fewer than three sites.
    """
    maps = _maps((real, simulated), activities, folds, by_subject, seed)
    shared = [name for name in activities if all(name in found.activities for found in maps)]
    if any(len(found.activities) > len(shared) for found in maps):
        maps = _maps((real, simulated), shared, folds, by_subject, seed)
    samples = [_resampled(found, seed + number) for number, found in enumerate(maps)]
    by_activity = {
        name: rank_agreement(
            *(found.f1[:, column] for found in maps), *(drawn[:, :, column] for drawn in samples), seed=seed
        )
        for column, name in enumerate(maps[0].activities)
    }
    overall = rank_agreement(
        maps[0].mean, maps[1].mean, samples[0].mean(axis=2), samples[1].mean(axis=2), seed=seed
    )
    low, high = np.quantile(_mean_rho(*samples), [0.025, 0.975])
    return SiteValidation(
        sites=tuple(sites),
        real=maps[0],
        simulated=maps[1],
        by_activity=by_activity,
        overall=overall,
        mean_rho=float(_mean_rho(maps[0].f1, maps[1].f1)),
        mean_low=float(low),
        mean_high=float(high),
        mean_p=_chance(maps[0].f1, maps[1].f1, seed),
        ceiling=_ceiling(maps[0], seed),
    )


def _maps(
    sides: Sequence[SiteWindows],
    activities: Sequence[str],
    folds: int,
    by_subject: Sequence[bool],
    seed: int,
) -> list[UtilityMap]:
    return [
        utility_map(
            side.features,
            side.activity,
            side.clip,
            side.subject if subjects else None,
            side.is_test,
            activities,
            folds=folds,
            seed=seed,
        )
        for side, subjects in zip(sides, by_subject, strict=True)
    ]


def _resampled(found: UtilityMap, seed: int) -> np.ndarray:
    """F1 of bootstrap resamples of the clips, shape (B, N, A)."""
    n_activities = len(found.activities)
    return resampled_f1(found.truth, found.predictions, found.clip, n_activities, RESAMPLES, seed)[1]


def _mean_rho(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Mean over activities of rho between scores (..., N, A); activities without a ranking stay out."""
    rho = spearman_rows(np.moveaxis(first, -1, -2), np.moveaxis(second, -1, -2))
    with np.errstate(invalid="ignore"):
        return np.nansum(rho, axis=-1) / np.maximum(1, np.isfinite(rho).sum(axis=-1))


def _chance(first: np.ndarray, second: np.ndarray, seed: int) -> float:
    """One-sided permutation p-value of the mean rho, the same renaming of sites for all activities."""
    rng = np.random.default_rng(seed)
    observed = _mean_rho(first, second)
    orders = np.array([rng.permutation(len(first)) for _ in range(RESAMPLES)])
    shuffled = _mean_rho(np.broadcast_to(first, (RESAMPLES, *first.shape)), second[orders])
    return float((1 + (shuffled >= observed - 1e-12).sum()) / (1 + RESAMPLES))


def _ceiling(found: UtilityMap, seed: int) -> float:
    """Mean rho between F1 in two random halves of the clips of each activity."""
    counts = count_by_clip(found.truth, found.predictions, found.clip, len(found.activities))
    rng = np.random.default_rng(seed)
    halves = np.zeros((2, HALVINGS, len(counts.size)), dtype=np.float32)
    for activity in np.unique(counts.activity):
        members = np.flatnonzero(counts.activity == activity)
        for halving in range(HALVINGS):
            rng.shuffle(members)
            middle = (len(members) + rng.integers(2)) // 2
            halves[0, halving, members[:middle]] = halves[1, halving, members[middle:]] = 1
    return float(np.nanmean(_mean_rho(*(f1_scores(counts, half) for half in halves))))
