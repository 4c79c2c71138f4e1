# SPDX-License-Identifier: GPL-3.0-or-later
"""Rank a library of several sources source by source, and see how far its map repeats.

Simulated sensors recognise the source of a clip. Compared with clips of its own source alone, an activity
cannot be told by its source; its score is the mean over the sources that show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..ranking.agreement import spearman_rows
from ..ranking.halves import deal_halves
from ..ranking.inputs import PatchBlocks, SomeWindows
from ..ranking.pooling import Pooling
from ..ranking.utility import UtilityMap, utility_map

FOLDS = 10
"""Most folds: up to so many performers are left out one at a time, more are dealt to so many folds."""

INNER_HALVINGS = 2
"""Ways in which each map's own clips are halved, to pool it."""

RESAMPLES = 20
"""Of the bootstrap, whose intervals are not used here."""


@dataclass(frozen=True, eq=False)
class MixedWindows:
    """Windows of a library of several sources.

    Attributes
    ----------
    inputs : PatchBlocks, shape (W, N, D)
        Features.
    activity, motion, source : ndarray of str, shape (W,)
    performer : ndarray of str, shape (W,)
        Who moves, with the source; where that is not known, the motion.
    is_test : ndarray of bool, shape (W,)
    """

    inputs: PatchBlocks
    activity: np.ndarray
    motion: np.ndarray
    source: np.ndarray
    performer: np.ndarray
    is_test: np.ndarray

    def part(self, rows: np.ndarray) -> MixedWindows:
        """Some of the windows, by a mask."""
        index = np.flatnonzero(rows)
        names = ("activity", "motion", "source", "performer", "is_test")
        held = self.inputs
        inputs = (
            SomeWindows(held.source, held.rows[index])
            if isinstance(held, SomeWindows)
            else SomeWindows(held, index)
        )
        return MixedWindows(inputs, *(getattr(self, name)[index] for name in names))

    def as_one_source(self) -> MixedWindows:
        """The windows as if one source had made them all."""
        return replace(self, source=np.full(len(self.source), "all sources"))

    def count(self, what: str) -> dict[str, int]:
        """Distinct values of `what` ("motion", "performer" or "source") by activity."""
        values = getattr(self, what)
        return {str(name): len(set(values[self.activity == name])) for name in np.unique(self.activity)}


@dataclass(frozen=True, eq=False)
class SourcedMap:
    """A map whose activities are compared with those of the same source alone.

    Attributes
    ----------
    activities : tuple of str, length A
    expected, f1 : ndarray, shape (N, A)
        Mean over the sources that show an activity: expected F1 (`UtilityMap.expected_f1`) and F1.
    parts : dict of str to UtilityMap
        By source.
    left_out : dict of str to str
        Sources in which nothing could be compared, each with the reason.
    """

    activities: tuple[str, ...]
    expected: np.ndarray
    f1: np.ndarray
    parts: dict[str, UtilityMap]
    left_out: dict[str, str]

    def of(self, activities: Sequence[str], kind: str = "expected") -> np.ndarray:
        """Expected F1, or F1 ("f1"), of some activities, shape (N, len(activities))."""
        return getattr(self, kind)[:, [self.activities.index(name) for name in activities]]

    def sources_of(self, activity: str) -> list[str]:
        """The sources in which an activity was compared with others."""
        return [source for source, found in self.parts.items() if activity in found.activities]


@dataclass(frozen=True, eq=False)
class Repeats:
    """How far maps of disjoint halves of the performers agree, over several halvings.

    Attributes
    ----------
    mean : ndarray, shape (H,)
        Spearman's rho of the mean over activities.
    by_activity : dict of str to ndarray, shape (H,)
        NaN where a half could not test the activity.
    raw : ndarray, shape (H,)
        Spearman's rho of macro F1, neither pooled over the skin nor shrunk.
    f1 : ndarray, shape (H,)
        Macro F1 of a half, at its best patch, as the other half's best patch delivers it.
    """

    mean: np.ndarray
    by_activity: dict[str, np.ndarray]
    raw: np.ndarray
    f1: np.ndarray

    @property
    def mean_by_activity(self) -> float:
        """Mean rho over activities and halvings."""
        return float(np.nanmean(list(self.by_activity.values())))


def rank_within_sources(
    windows: MixedWindows, pooling: Pooling | None = None, seed: int = 0, halvings: int = INNER_HALVINGS
) -> SourcedMap:
    """Rank every source alone, performers left out, and average activities over their sources.

    Raises
    ------
    ValueError
        If no source shows two activities by two performers each; the message says why.
    """
    parts, left_out = {}, {}
    for source in np.unique(windows.source).tolist():
        part = windows.part(windows.source == source)
        try:
            parts[source] = _ranked(part, part.activity, pooling, seed, halvings)
        except ValueError as error:
            left_out[source] = str(error)
    if not parts:
        raise ValueError("; ".join(f"{source}: {why}" for source, why in left_out.items()))
    activities = tuple(sorted({name for found in parts.values() for name in found.activities}))
    expected, f1 = (
        np.stack([_mean_over(parts, name, kind) for name in activities], axis=1)
        for kind in ("expected_f1", "f1")
    )
    return SourcedMap(activities, expected, f1, parts, left_out)


def _ranked(
    part: MixedWindows, labels: np.ndarray, pooling: Pooling | None, seed: int, halvings: int
) -> UtilityMap:
    """A map of one source's windows by any labels, whose performers are not trained on when tested."""
    folds = max(2, min(FOLDS, len(set(part.performer))))
    return utility_map(
        part.inputs, labels, part.performer, None, part.is_test, sorted(set(labels.tolist())),
        folds=folds, seed=seed, resamples=RESAMPLES, pooling=pooling, halvings=halvings,
    )  # fmt: skip


def _mean_over(parts: dict[str, UtilityMap], activity: str, kind: str) -> np.ndarray:
    return np.mean(
        [
            getattr(found, kind)[:, found.activities.index(activity)]
            for found in parts.values()
            if activity in found.activities
        ],
        axis=0,
    )


def repeats(
    windows: MixedWindows,
    pooling: Pooling | None = None,
    halvings: int = 4,
    clips: int | None = None,
    seed: int = 0,
) -> Repeats:
    """Compare the maps of disjoint halves of the performers of every source.

    Parameters
    ----------
    windows : MixedWindows
    pooling : Pooling, optional
    halvings : int
    clips : int, optional
        Motions of each activity in a half, over as many performers as there are; all where not given.
    seed : int
    """
    pairs = np.char.add(np.char.add(windows.source, "\n"), windows.activity)
    labels = np.unique(pairs, return_inverse=True)[1].ravel()
    names = sorted(set(windows.activity.tolist()))
    mean, raw, f1 = (np.full(halvings, np.nan) for _ in range(3))
    by_activity = {name: np.full(halvings, np.nan) for name in names}
    for number, side in enumerate(deal_halves(labels, windows.performer, seed, halvings)):
        halves = [windows.part(side), windows.part(~side)]
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
        for name, rho in zip(shared, _agreement(*(found.T for found in maps)), strict=True):
            by_activity[name][number] = rho
        mean[number] = _agreement(*(found.mean(axis=1)[None] for found in maps))[0]
        raw[number] = _agreement(*(found.of(shared, "f1").mean(axis=1)[None] for found in (one, other)))[0]
        best = [int(found.expected.mean(axis=1).argmax()) for found in (one, other)]
        f1[number] = np.mean([other.f1[best[0]].mean(), one.f1[best[1]].mean()])
    return Repeats(mean, by_activity, raw, f1)


def _agreement(first: np.ndarray, second: np.ndarray) -> np.ndarray:
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
        turn = np.array([(performer[:place] == who).sum() for place, who in enumerate(performer.tolist())])
        chosen = motions[order][np.argsort(turn, kind="stable")[:clips]]
        kept |= here & np.isin(windows.motion, chosen)
    return windows.part(kept)


def between_sources(found: SourcedMap) -> dict[str, float]:
    """Rho between the maps of an activity in different sources, the mean over their pairs."""
    rho = {}
    for name in found.activities:
        maps = [part.expected_f1[:, part.activities.index(name)] for part in
                (found.parts[source] for source in found.sources_of(name))]  # fmt: skip
        pairs = [(a, b) for number, a in enumerate(maps) for b in maps[number + 1 :]]
        if pairs:
            rho[name] = float(np.mean([_agreement(a[None], b[None])[0] for a, b in pairs]))
    return rho


def across_sources(windows: MixedWindows, seed: int = 0) -> UtilityMap:
    """Leave one source out at a time: train on the others, test on it.

    Raises
    ------
    ValueError
        If fewer than two activities are shown by two sources; the message says why.
    """
    sources = windows.count("source")
    kept = windows.part(np.isin(windows.activity, [name for name, count in sources.items() if count > 1]))
    return utility_map(
        kept.inputs, kept.activity, kept.motion, kept.source, kept.is_test,
        sorted(set(kept.activity.tolist())), seed=seed, resamples=RESAMPLES, halvings=0,
    )  # fmt: skip
