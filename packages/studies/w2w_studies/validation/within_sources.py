# SPDX-License-Identifier: GPL-3.0-or-later
"""Rank a library of several sources source by source.

Simulated sensors recognise the source of a clip. Compared with clips of its own source alone, an activity
cannot be told by its source; its score is the mean over the sources that show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.windows.inputs import PatchBlocks

from .some_windows import some_windows

FOLDS = 10
"""Most folds: up to so many performers are left out one at a time, more are dealt to so many folds."""

INNER_HALVINGS = 2
"""Ways in which each map's own clips are halved, to pool it."""

RESAMPLES = 20
"""Resamples of the bootstrap, whose intervals are not used here."""


class MixedWindows(NamedTuple):
    """Windows of a library of several sources."""

    inputs: PatchBlocks  # (W, N, D): features
    activity: np.ndarray  # (W,) of str
    motion: np.ndarray  # (W,) of str
    source: np.ndarray  # (W,) of str
    performer: np.ndarray  # (W,) of str: who moves, with the source; where that is not known, the motion
    is_test: np.ndarray  # (W,) of bool

    some = some_windows

    def as_one_source(self) -> MixedWindows:
        """The windows as if one source had made them all."""
        return self._replace(source=np.full(len(self.source), "all sources"))

    def count(self, what: str) -> dict[str, int]:
        """Distinct values of `what` ("motion", "performer" or "source") by activity."""
        values = getattr(self, what)
        return {str(name): len(set(values[self.activity == name])) for name in np.unique(self.activity)}


@dataclass(frozen=True, eq=False)
class SourcedMap:
    """A map whose activities are compared with those of the same source alone."""

    activities: tuple[str, ...]  # length A
    expected: np.ndarray
    f1: np.ndarray
    """(N, A): mean over the sources that show an activity: expected F1 (`UtilityMap.expected_f1`) and F1."""
    parts: dict[str, UtilityMap]  # by source
    left_out: dict[str, str]  # sources in which nothing could be compared, each with the reason

    def of(self, activities: Sequence[str], kind: str = "expected") -> np.ndarray:
        """Expected F1, or F1 ("f1"), of some activities, shape (N, len(activities))."""
        return getattr(self, kind)[:, [self.activities.index(name) for name in activities]]

    def sources_of(self, activity: str) -> list[str]:
        """The sources in which an activity was compared with others."""
        return [source for source, found in self.parts.items() if activity in found.activities]

    def without(self, source: str) -> SourcedMap | None:
        """The map of the other sources, or None if there are none."""
        others = {name: found for name, found in self.parts.items() if name != source}
        return sourced_map(others, self.left_out) if others else None


def rank_within_sources(
    windows: MixedWindows, pooling: Pooling | None = None, seed: int = 0, halvings: int = INNER_HALVINGS
) -> SourcedMap:
    """Rank every source alone, performers left out, and average activities over their sources.

    Raises ValueError if no source shows two activities by two performers each; the message says why.
    """
    parts, left_out = {}, {}
    for source in np.unique(windows.source).tolist():
        part = windows.some(windows.source == source)
        try:
            parts[source] = _ranked(part, part.activity, pooling, seed, halvings)
        except ValueError as error:
            left_out[source] = str(error)
    if not parts:
        raise ValueError("; ".join(f"{source}: {why}" for source, why in left_out.items()))
    return sourced_map(parts, left_out)


def sourced_map(parts: dict[str, UtilityMap], left_out: dict[str, str]) -> SourcedMap:
    """The map of activities, each the mean over the sources whose maps hold it."""
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
        part.inputs,
        CrossValidation(
            labels, part.performer, None, part.is_test, sorted(set(labels.tolist())), folds=folds, seed=seed
        ),
        resamples=RESAMPLES,
        pooling=pooling,
        halvings=halvings,
    )


def _mean_over(parts: dict[str, UtilityMap], activity: str, kind: str) -> np.ndarray:
    return np.mean(
        [
            getattr(found, kind)[:, found.activities.index(activity)]
            for found in parts.values()
            if activity in found.activities
        ],
        axis=0,
    )
