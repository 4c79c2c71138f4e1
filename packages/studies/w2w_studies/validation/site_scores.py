# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 of each site on one side, and of resamples and halves of the people or clips it was tested on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from w2w.core.ranking.f1 import ClipCounts, ClipUnits, clip_resamples, f1_scores
from w2w.core.ranking.utility import UtilityMap

RESAMPLES = 2000
HALVINGS = 200
TAIL = (0.025, 0.975)


@dataclass(frozen=True, eq=False)
class SiteScores:
    """F1 by site and activity, and how sure it is."""

    activities: tuple[str, ...]  # length A
    f1: np.ndarray  # (S, A)
    samples: np.ndarray
    """(B, S, A): of bootstrap resamples of the people, or of the clips of each activity; NaN where an
    activity was not drawn."""
    halves: np.ndarray
    """(2, H, S, A): of the two halves of the people, or of the clips of each activity, in H random
    halvings."""
    units: str  # {"people", "clips"}: what was resampled and halved
    n_units: int
    n_clips: int
    n_windows: int
    """People or clips, clips and windows tested."""
    classifier: str
    protocol: str
    """The same as in `UtilityMap`."""
    left_out: dict[str, str]

    def without(self, background: Sequence[str]) -> SiteScores:
        """The scores of the other activities, which were trained against these.

        Raises ValueError if none is left.
        """
        kept = [name for name in self.activities if name not in background]
        if not kept:
            raise ValueError(f"nothing but background can be tested: {', '.join(self.activities)}")
        return self.of(kept)

    def of(self, activities: Sequence[str]) -> SiteScores:
        """The scores of some activities, in that order."""
        kept = [self.activities.index(name) for name in activities]
        return replace(
            self,
            activities=tuple(activities),
            f1=self.f1[:, kept],
            samples=self.samples[..., kept],
            halves=self.halves[..., kept],
        )

    @property
    def mean(self) -> np.ndarray:
        """Macro F1, shape (S,)."""
        return self.f1.mean(axis=1)

    @property
    def mean_samples(self) -> np.ndarray:
        """Macro F1 of each resample, shape (B, S)."""
        return np.nanmean(self.samples, axis=2)

    @property
    def f1_interval(self) -> np.ndarray:
        """95 % interval of `f1`, shape (2, S, A)."""
        return np.nanquantile(self.samples, TAIL, axis=0)

    @property
    def mean_interval(self) -> np.ndarray:
        """95 % interval of `mean`, shape (2, S)."""
        return np.nanquantile(self.mean_samples, TAIL, axis=0)


def site_scores(
    found: UtilityMap,
    person_of: Mapping[str, str] | None = None,
    site_of: np.ndarray | None = None,
    seed: int = 0,
) -> SiteScores:
    """Scores of sites from a map of sensors.

    `found`: of P sensors.
    `person_of`: who is seen in each clip. Where given, people are resampled and halved, else the clips of
    each activity.
    `site_of` (P,) of int: site of each sensor, 0 to S - 1; a site's score is the mean over its sensors. By
    default each sensor is a site.
    """
    n_activities = len(found.activities)
    unit = found.clip if person_of is None else np.array([person_of[clip] for clip in found.clip.tolist()])
    counts = ClipUnits(found.truth, unit, n_activities).count(found.predictions)
    names, index = np.unique(unit, return_inverse=True)
    person = None if person_of is None else np.unique(index * n_activities + found.truth) // n_activities
    rng = np.random.default_rng(seed)
    pooled = _mean_over(np.arange(found.f1.shape[0]) if site_of is None else site_of)
    return SiteScores(
        activities=found.activities,
        f1=pooled @ found.f1.astype(np.float64),
        samples=pooled @ _scored(counts, _resamples(counts, person, rng)),
        halves=np.stack([pooled @ _scored(counts, half) for half in _halves(counts, person, rng)]),
        units="clips" if person_of is None else "people",
        n_units=len(names),
        n_clips=len(np.unique(found.clip)),
        n_windows=len(found.truth),
        classifier=found.classifier,
        protocol=found.protocol,
        left_out=found.left_out,
    )


def _mean_over(site_of: np.ndarray) -> np.ndarray:
    """Matrix (S, P) that takes the mean over each site's sensors."""
    belongs = np.asarray(site_of) == np.arange(int(np.max(site_of)) + 1)[:, None]
    return belongs / belongs.sum(axis=1, keepdims=True)


def _scored(counts: ClipCounts, weights: np.ndarray) -> np.ndarray:
    """F1 (B, P, A) of resamples; NaN where an activity was not drawn."""
    return f1_scores(counts, weights).astype(np.float64)


def _resamples(counts: ClipCounts, person: np.ndarray | None, rng: np.random.Generator) -> np.ndarray:
    """How often each count is drawn, shape (B, C): with whoever it is of, or within its activity."""
    if person is None:
        return clip_resamples(counts.activity, RESAMPLES, rng)
    n_people = int(person.max()) + 1
    return rng.multinomial(n_people, np.full(n_people, 1 / n_people), size=RESAMPLES)[:, person]


def _halves(counts: ClipCounts, person: np.ndarray | None, rng: np.random.Generator) -> np.ndarray:
    """Which counts are in each half, shape (2, H, C), as 0 and 1."""
    halves = np.zeros((2, HALVINGS, len(counts.size)), dtype=np.float32)
    groups = [np.arange(len(counts.size))] if person is not None else []
    of = np.arange(len(counts.size)) if person is None else person
    if person is None:
        groups = [np.flatnonzero(counts.activity == a) for a in np.unique(counts.activity)]
    for group in groups:
        members = np.unique(of[group])
        for halving in range(HALVINGS):
            rng.shuffle(members)
            middle = (len(members) + rng.integers(2)) // 2
            for half, chosen in enumerate((members[:middle], members[middle:])):
                halves[half, halving, group[np.isin(of[group], chosen)]] = 1
    return halves
