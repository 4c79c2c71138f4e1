# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the map of a library of several sources comes out the same with other performers."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from w2w.core.ranking.agreement import spearman_rows
from w2w.core.ranking.halves import deal_halves
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap

from .within_sources import MixedWindows, SourcedMap, rank_within_sources


class MeansAgree(NamedTuple):
    """How far two maps agree in what they say of all activities together: Spearman's rho over the patches."""

    of_activities: float  # of the mean over activities
    of_sources: float  # of the mean over sources, each the mean over its own activities


@dataclass(frozen=True, eq=False)
class Repeats:
    """How far maps of disjoint halves of the performers agree, over several halvings."""

    mean: np.ndarray  # (H,): Spearman's rho of the mean over activities
    by_activity: dict[str, np.ndarray]  # (H,): naN where a half could not test the activity
    raw: np.ndarray  # (H,): Spearman's rho of macro F1, neither pooled over the skin nor shrunk
    f1: np.ndarray  # (H,): macro F1 of a half, at its best patch, as the other half's best patch delivers it
    of_sources: np.ndarray
    """(H,): Spearman's rho of the mean over sources, each the mean over its own activities."""
    left_out: dict[str, list[MeansAgree]] = field(default_factory=dict)  # the same halvings less one source

    @property
    def mean_by_activity(self) -> float:
        """Mean rho over activities and halvings."""
        return float(np.nanmean(list(self.by_activity.values())))


def repeats(
    windows: MixedWindows,
    pooling: Pooling | None = None,
    halvings: int = 4,
    clips: int | None = None,
    seed: int = 0,
) -> Repeats:
    """Compare the maps of disjoint halves of the performers of every source.

    `clips`: motions of each activity in a half, over as many performers as there are; all where not given.
    """
    pairs = np.char.add(np.char.add(windows.source, "\n"), windows.activity)
    labels = np.unique(pairs, return_inverse=True)[1].ravel()
    names = sorted(set(windows.activity.tolist()))
    mean, raw, f1, of_sources = (np.full(halvings, np.nan) for _ in range(4))
    by_activity = {name: np.full(halvings, np.nan) for name in names}
    left_out: dict[str, list[MeansAgree]] = {}
    for number, side in enumerate(deal_halves(labels, windows.performer, seed, halvings)):
        halves = [windows.some(side), windows.some(~side)]
        if clips is not None:
            halves = [_drawn(half, clips, seed + number) for half in halves]
        try:
            one, other = (rank_within_sources(half, pooling, seed) for half in halves)
        except ValueError:
            continue  # a half in which nothing can be compared says nothing of the other
        shared = [name for name in one.activities if name in other.activities]
        if not shared:
            continue
        maps = one.of(shared), other.of(shared)
        for name, rho in zip(shared, agreement(*(found.T for found in maps)), strict=True):
            by_activity[name][number] = rho
        mean[number], of_sources[number] = means_agree(one, other)
        raw[number] = agreement(*(found.of(shared, "f1").mean(axis=1)[None] for found in (one, other)))[0]
        best = [int(found.expected.mean(axis=1).argmax()) for found in (one, other)]
        f1[number] = np.mean([other.f1[best[0]].mean(), one.f1[best[1]].mean()])
        for source, found in _less_one_source(one, other).items():
            left_out.setdefault(source, []).append(found)
    return Repeats(mean, by_activity, raw, f1, of_sources, left_out)


def means_agree(one: SourcedMap, other: SourcedMap) -> MeansAgree:
    """Compare two maps by what both hold; NaN where that is nothing."""
    shared = [name for name in one.activities if name in other.activities]
    sources = {
        source: [name for name in part.activities if name in other.parts[source].activities]
        for source, part in one.parts.items()
        if source in other.parts
    }
    sources = {source: names for source, names in sources.items() if names}
    if not shared or not sources:
        return MeansAgree(np.nan, np.nan)
    activities = (found.of(shared).mean(axis=1)[None] for found in (one, other))
    of_sources = (
        np.mean([_mean_of(found.parts[source], names) for source, names in sources.items()], axis=0)[None]
        for found in (one, other)
    )
    return MeansAgree(float(agreement(*activities)[0]), float(agreement(*of_sources)[0]))


def _mean_of(part: UtilityMap, activities: list[str]) -> np.ndarray:
    return part.expected_f1[:, [part.activities.index(name) for name in activities]].mean(axis=1)


def _less_one_source(one: SourcedMap, other: SourcedMap) -> dict[str, MeansAgree]:
    """The comparison again without each source that both maps hold, while any other is left."""
    found = {}
    for source in one.parts:
        pair = one.without(source), other.without(source)
        if source in other.parts and None not in pair:
            found[source] = means_agree(*pair)
    return found


def agreement(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Rho of each row; a flat map agrees with none."""
    return np.nan_to_num(spearman_rows(first, second))


def _drawn(windows: MixedWindows, clips: int, seed: int) -> MixedWindows:
    """So many motions of each activity at most, from its performers in turn."""
    rng = np.random.default_rng([seed, clips])
    kept = np.zeros(len(windows.activity), dtype=bool)
    for name in np.unique(windows.activity):
        here = windows.activity == name
        motions, first = np.unique(windows.motion[here], return_index=True)
        order = rng.permutation(len(motions))
        performer = windows.performer[here][first][order]
        turn = np.array([(performer[:before] == who).sum() for before, who in enumerate(performer.tolist())])
        chosen = motions[order][np.argsort(turn, kind="stable")[:clips]]
        kept |= here & np.isin(windows.motion, chosen)
    return windows.some(kept)
