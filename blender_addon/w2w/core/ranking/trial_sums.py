# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches added up over windows, so that no window's scores need be kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .f1 import f1_of, window_counts
from .halves import Plan, Scored
from .inputs import PatchBlocks, SomePatches
from .planned import Planned

TASK_PATCHES = 16
"""Patches that are tried in one piece elsewhere."""


class Tried(NamedTuple):
    """Results of the trials of a plan for N patches."""

    predictions: np.ndarray  # (W_test, N), int16: activities that the whole named
    f1: np.ndarray  # (trials, A, N): F1 by window; NaN where an activity was not tested

    @classmethod
    def joined(cls, parts: Sequence[Tried]) -> Tried:
        """Results for all patches, from those for some after others."""
        return cls(*(np.concatenate(of_parts, axis=-1) for of_parts in zip(*parts, strict=True)))


WHOLE = 0
"""Number of the trial on all clips, the first of a plan."""

Spread = Callable[[Callable[[tuple[int, int]], Tried], Sequence[tuple[int, int]]], Iterable[Tried]]
"""Calls a function with each of some items, wherever, and gives the results in their order: as `map` does."""


def try_patches(
    model: Any,
    source: PatchBlocks,
    trial: Planned,
    settings: np.ndarray,
    span: tuple[int, int],
    progress: Callable[[float], None] | None = None,
) -> Tried:
    """Try the patches of `source` from the first of a span to before its last.

    By a model with `score_splits`, as `Ridge` has, and its `settings` (splits, models) of that name;
    `progress` is given the fraction done.
    """
    plan, some = trial.plan, SomePatches(source, *span)
    sums = TrialSums(trial.labels, trial.is_test, plan, some.shape[1])
    model.score_splits(some, trial.labels, plan.block, plan.splits, settings, sums.add, progress)
    return Tried(sums.predictions, sums.f1())


class TrialSums:
    """Hits and names of each trial of a plan, and the activities that the whole names, patch by patch.

    From labels (W,) and `is_test` (W,); `predictions` (W_test, N), int16, are the whole's.
    """

    def __init__(self, labels: np.ndarray, is_test: np.ndarray, plan: Plan, n_patches: int) -> None:
        self._labels, self._plan = labels, plan
        self._position = np.cumsum(is_test) - 1
        self._of_split: dict[int, list[int]] = {}
        for number, trial in enumerate(plan.trials):
            for split in trial.splits:
                self._of_split.setdefault(split, []).append(number)
        n_trials, n_activities = len(plan.trials), len(plan.whole.testable)
        self.predictions = np.empty((int(is_test.sum()), n_patches), dtype=np.int16)
        self._counts = np.zeros((n_patches, n_trials, 3, n_activities), dtype=np.int64)

    def add(self, patch: int, scored: Iterable[Scored]) -> None:
        """Take in scores of a patch, some after the other."""
        for some in scored:
            windows = self._plan.splits[some.split].tested[some.place]
            true, named = self._labels[windows], some.scores[:, 0].argmax(axis=0)
            trials = self._of_split[some.split]
            self._counts[patch, trials] += window_counts(named, true, len(some.scores))
            if trials[0] == WHOLE:
                self.predictions[self._position[windows], patch] = named

    def f1(self) -> np.ndarray:
        """F1 by window of each trial, shape (trials, A, N)."""
        return np.moveaxis(f1_of(*np.moveaxis(self._counts, -2, 0)), 0, 2)
