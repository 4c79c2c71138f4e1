# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches added up over windows, so that no window's scores need be kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .expected import TrialMaps
from .halves import Plan, Scored
from .inputs import PatchBlocks, SomePatches
from .map_scores import f1_of, rank_score_of, rank_sums, ranks_of, window_counts
from .planned import Planned

TASK_PATCHES = 16
"""Patches that are tried in one piece elsewhere."""
RANKED_AT_ONCE = 4096
"""Windows from which on those of a patch are ranked: a few at a time take thrice as long."""


class Tried(NamedTuple):
    """What the trials of a plan said of some patches.

    Attributes
    ----------
    predictions : ndarray, shape (W_test, N), int16
        Activity that the whole named.
    maps : TrialMaps
    """

    predictions: np.ndarray
    maps: TrialMaps

    @classmethod
    def joined(cls, parts: Sequence[Tried]) -> Tried:
        """Of all patches, from some after others."""
        score, raw = (
            np.concatenate([getattr(part.maps, name) for part in parts], axis=2) for name in ("score", "raw")
        )
        return cls(np.concatenate([part.predictions for part in parts], axis=1), TrialMaps(score, raw))


Spread = Callable[[Callable[[tuple[int, int]], Tried], Sequence[tuple[int, int]]], Iterable[Tried]]
"""Calls something with each of some items, wherever, and gives the results in their order: as `map` does."""


def try_patches(
    model: Any,
    source: PatchBlocks,
    trial: Planned,
    settings: np.ndarray,
    span: tuple[int, int],
    progress: Callable[[float], None] | None = None,
) -> Tried:
    """Try the patches from the first of a span to before its last.

    Parameters
    ----------
    model : object
        With a `score_splits`, as `Ridge` has.
    source : PatchBlocks
        Of all patches.
    trial : Planned
    settings : ndarray, shape (splits, models)
        As the model's `settings` gives them.
    span : two ints
    progress : callable, optional
        Told the fraction done.
    """
    plan, some = trial.plan, SomePatches(source, *span)
    sums = TrialSums(trial.labels, trial.is_test, plan, settings.shape[1], some.shape[1])
    model.score_splits(some, trial.labels, plan.block, plan.splits, settings, sums.add, progress)
    return Tried(sums.predictions, sums.maps())


class TrialSums:
    """What the trials of a plan say of some patches: names of the windows of the whole, and sums for maps.

    Parameters
    ----------
    labels : ndarray of int, shape (W,)
        Activity of each window.
    is_test : ndarray of bool, shape (W,)
    plan : Plan
    n_models : int
        Models of each patch whose scores are averaged; the first one names windows.
    n_patches : int

    Attributes
    ----------
    predictions : ndarray, shape (W_test, N), int16
        Activity that the whole's first model named.
    """

    def __init__(
        self, labels: np.ndarray, is_test: np.ndarray, plan: Plan, n_models: int, n_patches: int
    ) -> None:
        self._labels, self._plan = labels, plan
        self._position = np.cumsum(is_test) - 1
        self._of_split: dict[int, list[tuple[int, int]]] = {}
        for number, trial in enumerate(plan.trials):
            first = 0
            for split in trial.splits:
                self._of_split.setdefault(split, []).append((number, first))
                first += len(plan.splits[split].tested)
        n_trials, n_activities = len(plan.trials), len(plan.whole.testable)
        self.predictions = np.empty((int(is_test.sum()), n_patches), dtype=np.int16)
        self._sums = np.zeros((n_patches, n_trials, n_models, 4, n_activities))
        self._counts = np.zeros((n_patches, n_trials, 3, n_activities), dtype=np.int64)

    def add(self, patch: int, scored: Iterable[Scored]) -> None:
        """Take in scores of a patch, some after the other."""
        held: list[Scored] = []
        for some in scored:
            held.append(some)
            if sum(one.scores.shape[2] for one in held) >= RANKED_AT_ONCE:
                self._take_in(patch, held)
                held.clear()
        if held:
            self._take_in(patch, held)

    def _take_in(self, patch: int, together: Sequence[Scored]) -> None:
        scores = np.concatenate([some.scores for some in together], axis=2)
        windows = np.concatenate([self._plan.splits[some.split].tested[some.place] for some in together])
        weights = np.concatenate([self._weights(some) for some in together], axis=1)
        true, named, ranks = self._labels[windows], scores[:, 0].argmax(axis=0), ranks_of(scores)
        for number, weight in enumerate(weights):
            of = np.flatnonzero(weight)
            self._sums[patch, number] += rank_sums(ranks.take(of, axis=2), true[of], weight[of])
            self._counts[patch, number] += window_counts(named[of], true[of], len(scores))
        of_whole = weights[0] > 0
        self.predictions[self._position[windows[of_whole]], patch] = named[of_whole]

    def _weights(self, some: Scored) -> np.ndarray:
        """What windows count in each trial, shape (trials, v): nothing where it does not test them."""
        weights = np.zeros((len(self._plan.trials), some.scores.shape[2]))
        for number, start in self._of_split[some.split]:
            weights[number] = self._plan.trials[number].weight[start:][some.place]
        return weights

    def maps(self) -> TrialMaps:
        """Maps of each trial."""
        score = rank_score_of(self._sums).mean(axis=2)
        return TrialMaps(*(np.moveaxis(values, 0, 2) for values in (score, f1_of(self._counts))))
