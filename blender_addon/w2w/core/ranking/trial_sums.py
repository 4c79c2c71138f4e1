# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches added up over windows, so that no window's scores need be kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .expected import TrialMaps
from .halves import Plan
from .inputs import PatchBlocks, SomePatches
from .map_scores import f1_of, rank_score_of, rank_sums, window_counts
from .planned import Planned

TASK_PATCHES = 16
"""Patches that are tried in one piece elsewhere."""


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

    def add(self, patch: int, split: int, first: int, scores: np.ndarray) -> None:
        """Take in scores (models, v, A) of windows that a split tests, from its window `first` on."""
        windows = self._plan.splits[split].tested[first : first + scores.shape[1]]
        true, named = self._labels[windows], scores[0].argmax(axis=1)
        counts = window_counts(named, true, scores.shape[2])
        for number, start in self._of_split[split]:
            begin = start + first
            weight = self._plan.trials[number].weight[begin : begin + len(windows)]
            self._sums[patch, number] += rank_sums(scores, true, weight)
            self._counts[patch, number] += counts
        if split in self._plan.whole.splits:
            self.predictions[self._position[windows], patch] = named

    def maps(self) -> TrialMaps:
        """Maps of each trial."""
        score = rank_score_of(self._sums).mean(axis=2)
        return TrialMaps(*(np.moveaxis(values, 0, 2) for values in (score, f1_of(self._counts))))
