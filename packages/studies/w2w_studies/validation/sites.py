# SPDX-License-Identifier: GPL-3.0-or-later
"""Do simulated sensors rank sites as real ones do: F1 by site and activity on both sides, and agreement."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from w2w.core.ranking.agreement import Agreement, bootstrap_interval, rank_agreement, spearman_rows
from w2w.core.ranking.utility import UtilityMap

from .regret import Regret, regret
from .site_scores import RESAMPLES, TAIL, SiteScores, site_scores
from .site_windows import SiteWindows


class Estimate(NamedTuple):
    """A number and its 95 % interval over people and clips."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class SiteValidation:
    """Agreement of two maps of the same sites."""

    sites: tuple[str, ...]
    real: SiteScores
    simulated: SiteScores
    by_activity: dict[str, Agreement]  # naN where one side cannot tell its sites apart
    overall: Agreement  # of macro F1
    mean_rho: float
    mean_low: float
    mean_high: float
    """Mean of the activities' rho, and its bootstrap interval."""
    mean_p: float  # chance of a mean this high if the simulated sites were called by each other's names
    ceiling: Estimate
    overall_ceiling: Estimate
    """Rho that as many other people would reach, or clips where nobody knows who is who, as the mean over
    activities and of macro F1: from the rho of random halves by Spearman-Brown. The intervals hold 95 % of
    the halvings."""
    cells: Estimate  # Pearson's r of real and simulated F1 over sites and activities
    cells_ceiling: float
    """What that r could be at most, for neither side repeats itself: the root of both sides' reliability,
    each from the r between its halves (Spearman 1904; Spearman-Brown for the whole)."""
    regret: Regret
    regret_by_activity: Regret
    """With one site for all activities, and with one for each."""

    def sentence(self, target: float = 0.85) -> str:
        """What was found, with how coarse it is."""
        defined = [name for name, found in self.by_activity.items() if np.isfinite(found.spearman)]
        reached = "reaches" if self.mean_rho >= target else "is below"
        n = len(self.sites)
        return (
            f"Over {len(defined)} activities and {n} sites the mean Spearman rho between real and simulated "
            f"rankings is {self.mean_rho:.2f} (95 % interval {self.mean_low:.2f} to {self.mean_high:.2f}, "
            f"p = {self.mean_p:.3f}), which {reached} {target:g}; as many other {self.real.units} "
            f"would agree at {self.ceiling.value:.2f}, and with {n} sites one swap of neighbours costs an "
            f"activity's rho {self.overall.step:.2f}."
        )

    @property
    def level(self) -> Estimate:
        """Simulated macro F1 less that of people, the mean over sites."""
        above = float((self.simulated.mean - self.real.mean).mean())
        drawn = (self.simulated.mean_samples - self.real.mean_samples).mean(axis=1)
        return Estimate(above, *bootstrap_interval(above, drawn))

    def level_sentence(self) -> str:
        """How far simulated F1 is above or below people's."""
        side = "above" if self.level.value >= 0 else "below"
        return (
            f"Simulated F1 lies {abs(self.level.value):.2f} {side} people's, the mean over sites (difference "
            f"{self.level.low:.2f} to {self.level.high:.2f})."
        )

    def regret_sentence(self) -> str:
        """What a wearer loses who follows the simulation."""
        return (
            f"Worn where simulation says, a sensor loses {self.regret.lost:.3f} of real F1 "
            f"({self.regret.low:.3f} to {self.regret.high:.3f}) against the really best site; a site chosen "
            f"at random loses {self.regret.at_random:.3f}. With a site for each activity it is "
            f"{self.regret_by_activity.lost:.3f} ({self.regret_by_activity.low:.3f} to "
            f"{self.regret_by_activity.high:.3f}) against {self.regret_by_activity.at_random:.3f}."
        )


def validate_sites(
    real: SiteWindows,
    simulated: SiteWindows,
    sites: Sequence[str],
    activities: Sequence[str],
    folds: int = 5,
    by_subject: tuple[bool, bool] = (False, False),
    seed: int = 0,
    site_of: np.ndarray | None = None,
    real_site_of: np.ndarray | None = None,
    classifier: str = "ridge",
    background: Sequence[str] = (),
) -> SiteValidation:
    """Train and test each site on real windows, then on simulated ones, and compare the rankings.

    `real`, `simulated`: of the same sites. Where both hold the same clips, both are dealt to the same folds.
    `activities`: only those that can be tested on both sides are.
    `by_subject`: leave one subject out at a time, on the real and on the simulated side. Intervals and halves
    are then over people.
    `site_of` of int: site of each simulated sensor, where a site has several; its score is the mean over
    them.
    `real_site_of` of int: likewise of each real one.
    `classifier`: name in `utility.CLASSIFIERS`; the windows hold what it takes.
    `background`: activities that the others are trained against, not compared themselves.
    Raises ValueError if fewer than two activities can be tested on both sides, or there are fewer than three
    sites.
    """
    sides = (real, simulated)
    maps = _maps(sides, activities, folds, by_subject, seed, classifier)
    shared = [name for name in activities if all(name in found.activities for found in maps)]
    if any(len(found.activities) > len(shared) for found in maps):
        again = _maps(sides, shared, folds, by_subject, seed, classifier)
        maps = [replace(found, left_out=before.left_out) for found, before in zip(again, maps, strict=True)]
    scores = [
        site_scores(found, side.person_of() if people else None, of, seed + number)
        for number, (found, side, people, of) in enumerate(
            zip(maps, sides, by_subject, (real_site_of, site_of), strict=True)
        )
    ]
    return compare_scores(*(side.without(background) for side in scores), sites, seed)


def compare_scores(
    real: SiteScores, simulated: SiteScores, sites: Sequence[str], seed: int = 0
) -> SiteValidation:
    """Compare two sides' scores of the same sites and activities."""
    scores, samples = (real.f1, simulated.f1), (real.samples, simulated.samples)
    by_activity = {
        name: rank_agreement(
            *(side[:, column] for side in scores), *(drawn[:, :, column] for drawn in samples), seed=seed
        )
        for column, name in enumerate(real.activities)
    }
    means = (real.mean, simulated.mean)
    mean_samples = (real.mean_samples, simulated.mean_samples)
    rho = float(mean_rho(*scores))
    low, high = bootstrap_interval(rho, mean_rho(*samples))
    return SiteValidation(
        sites=tuple(sites),
        real=real,
        simulated=simulated,
        by_activity=by_activity,
        overall=rank_agreement(*means, *mean_samples, seed=seed),
        mean_rho=rho,
        mean_low=low,
        mean_high=high,
        mean_p=_chance(*scores, seed),
        ceiling=_over_halvings(mean_rho(*real.halves)),
        overall_ceiling=_over_halvings(spearman_rows(*(np.nanmean(h, axis=2) for h in real.halves))),
        cells=_over_cells(scores, samples),
        cells_ceiling=float(np.sqrt(np.prod([_reliability(side) for side in (real, simulated)]))),
        regret=regret(*(side[..., None] for side in (*means, *mean_samples))),
        regret_by_activity=regret(*scores, *samples),
    )


def _maps(
    sides: Sequence[SiteWindows],
    activities: Sequence[str],
    folds: int,
    by_subject: Sequence[bool],
    seed: int,
    classifier: str,
) -> list[UtilityMap]:
    return [
        side.ranked(activities, subjects, classifier=classifier, folds=folds, seed=seed)
        for side, subjects in zip(sides, by_subject, strict=True)
    ]


def mean_rho(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Mean over activities of rho between scores (..., S, A); activities without a ranking stay out."""
    rho = spearman_rows(np.moveaxis(first, -1, -2), np.moveaxis(second, -1, -2))
    with np.errstate(invalid="ignore"):
        return np.nansum(rho, axis=-1) / np.maximum(1, np.isfinite(rho).sum(axis=-1))


def _chance(first: np.ndarray, second: np.ndarray, seed: int) -> float:
    """One-sided permutation p-value of the mean rho, the same renaming of sites for all activities."""
    rng = np.random.default_rng(seed)
    observed = mean_rho(first, second)
    orders = np.array([rng.permutation(len(first)) for _ in range(RESAMPLES)])
    shuffled = mean_rho(np.broadcast_to(first, (RESAMPLES, *first.shape)), second[orders])
    return float((1 + (shuffled >= observed - 1e-12).sum()) / (1 + RESAMPLES))


def _cell_r(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Pearson's r over the cells of scores (..., S, A), shape (...); cells that lack a score stay out."""
    known = np.isfinite(first) & np.isfinite(second)
    a, b = (np.where(known, side, np.nan).reshape(*side.shape[:-2], -1) for side in (first, second))
    a, b = (side - np.nanmean(side, axis=-1, keepdims=True) for side in (a, b))
    with np.errstate(invalid="ignore"):
        return np.nansum(a * b, axis=-1) / np.sqrt(np.nansum(a * a, axis=-1) * np.nansum(b * b, axis=-1))


def _over_cells(scores: Sequence[np.ndarray], samples: Sequence[np.ndarray]) -> Estimate:
    """Correlation over the cells; NaN if those of a side are all the same."""
    r = float(_cell_r(*scores))
    return Estimate(r, *bootstrap_interval(r, _cell_r(*samples)))


def _reliability(side: SiteScores) -> float:
    """Reliability of a side's cells, from the correlation of halves, 0 to 1."""
    return float(of_the_whole(np.nan_to_num(_cell_r(*side.halves)).mean()))


def of_the_whole(r: np.ndarray) -> np.ndarray:
    """What two sets as large as the whole would agree at, from the agreement of halves (Spearman-Brown)."""
    r = np.maximum(r, 0.0)
    return 2 * r / (1 + r)


def _over_halvings(rho: np.ndarray) -> Estimate:
    rho = np.nan_to_num(rho)  # halves in which nothing can be ranked do not agree
    return Estimate(
        *(float(value) for value in of_the_whole(np.array([rho.mean(), *np.quantile(rho, TAIL)])))
    )
