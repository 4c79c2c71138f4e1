# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores of patches added up over windows, so that no window's scores need be kept."""

from __future__ import annotations

import numpy as np

from .expected import TrialMaps
from .halves import Plan
from .map_scores import f1_of, rank_score_of, rank_sums, window_counts


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
