# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests by which sets of patches are chosen and judged: on all clips and on disjoint halves of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np

from ..ranking.classifiers.ridge import Ridge
from ..ranking.expected import most_shown
from ..ranking.f1 import class_auc, window_f1
from ..ranking.halves import CrossValidation, Plan, Trial, maps_of
from ..ranking.joint_scores import JointScores, Training
from ..ranking.pooling import Pooling
from ..ranking.utility import LEVEL, UtilityMap
from ..ranking.weights import mean_over
from ..windows.inputs import PatchBlocks, SomeWindows, as_blocks, spans

MOST_WINDOWS = 1000
"""Most windows on which a choice rests, evenly drawn: time grows with their square."""

READ_BYTES = 32 * 2**20
"""Features read at a time: they take memory in addition to those of all patches, which are held."""


@dataclass(frozen=True, eq=False)
class Tests:
    """The tests of one trial, by which a set is chosen or judged."""

    scores: JointScores
    labels: np.ndarray  # (V,): of the windows tested
    trial: Trial
    weights: np.ndarray  # (A,): what each activity counts
    pooling: Pooling
    known: np.ndarray | None  # (A, N): F1 of each patch alone, if a ranking has it

    def _f1(self, scores: np.ndarray) -> np.ndarray:
        return window_f1(scores.argmax(axis=1), self.labels, len(self.weights))

    @cached_property
    def alone(self) -> np.ndarray:
        """F1 of each patch alone, shape (A, N)."""
        if self.known is not None:
            return self.known
        return np.stack(self.scores.of_added((), range(self.scores.n_patches), self._f1), axis=1)

    @cached_property
    def single(self) -> np.ndarray:
        """Mean F1 of each patch alone, pooled over the skin, shape (N,)."""
        shown = self.trial.testable
        return mean_over(self.pooling.apply(self.alone[shown]), self.weights[shown], 0)

    def added(self, worn: Sequence[int], candidates: np.ndarray, worst: bool) -> np.ndarray:
        """Area under the ROC curve with each candidate added: the mean over activities, or the least."""
        shown = self.trial.testable

        def judge(scores: np.ndarray) -> np.ndarray:
            return class_auc(scores, self.labels, self.trial.weight)[shown]

        areas, weights = np.array(self.scores.of_added(worn, candidates.tolist(), judge)), self.weights[shown]
        return areas[:, weights > 0].min(axis=1) if worst else mean_over(areas, weights)

    def f1_of_first(self, order: Sequence[int]) -> np.ndarray:
        """F1 by the first patch, the first two, and so on, shape (K, A); NaN where not tested."""
        return self.f1_of_firsts([order], range(1, len(order) + 1))[0]

    def f1_of_firsts(self, orders: Sequence[Sequence[int]], sizes: Sequence[int]) -> np.ndarray:
        """F1 by the first patches of several orders, for ascending `sizes`; shape (orders, sizes, A)."""
        f1 = [list(map(self._f1, of_order)) for of_order in self.scores.each_first_of(orders, sizes)]
        return np.where(self.trial.testable, f1, np.nan)


@dataclass(frozen=True, eq=False)
class SetTests:
    """All tests by which sets of patches are chosen and judged."""

    whole: Tests  # on all clips
    halves: tuple[tuple[Tests, Tests], ...]  # pairs of disjoint halves of them, or of single subjects
    plan: Plan
    activities: tuple[str, ...]
    seed: int
    weights: np.ndarray  # (A,): what each activity counts
    most_shown: float  # highest lower bound of F1 that so many clips could show
    searches: dict[Any, Any] = field(default_factory=dict)  # those without wishes (`joint.choose_together`)

    @classmethod
    def of(
        cls,
        inputs: np.ndarray | PatchBlocks,
        protocol: CrossValidation,
        pooling: Pooling,
        utility: UtilityMap | None = None,
    ) -> SetTests:
        """Prepare the tests of a library, for features (W, N, D) as `Ridge` takes them.

        `utility`, the `utility_map` of the same inputs and protocol, saves ranking the halves again. Raises
        what `CrossValidation.plan` raises.
        """
        everything = protocol.plan()
        used = everything.used
        activity, clip = np.asarray(protocol.activity)[used], np.asarray(protocol.clip)[used]
        work = everything.among(_evenly(activity, clip, everything.is_test, MOST_WINDOWS))
        weights, shown = work.weights, most_shown(clip[everything.is_test], LEVEL)
        source = SomeWindows(as_blocks(inputs), work.used)
        ridge = Ridge().choose_alpha(source, work.labels, work.fold, work.is_test)
        features = _held(source)
        known: dict[Trial, np.ndarray] = {}  # F1 of each patch alone
        if utility is not None and (f1 := utility.trials_of(everything.plan)) is not None:
            maps = maps_of(f1.astype(np.float32), everything.plan)
            for pair, of_pair in zip(work.plan.pairs, maps, strict=False):  # the first are chosen by
                known.update(zip(pair, of_pair, strict=True))

        def tests(trial: Trial) -> Tests:
            trainings = [
                Training(np.flatnonzero(np.isin(work.plan.block, split.train)), split.tested)
                for split in (work.plan.splits[number] for number in trial.splits)
            ]
            scores = JointScores(features, work.labels, trainings, ridge)
            labels = work.labels[scores.windows]
            return Tests(scores, labels, trial, weights, pooling, known.get(trial))

        halves, whole = work.plan.pairs, work.plan.whole
        by_trial = {trial: tests(trial) for trial in dict.fromkeys([whole, *chain.from_iterable(halves)])}
        pairs = tuple((by_trial[a], by_trial[b]) for a, b in halves)
        return cls(by_trial[whole], pairs, work.plan, work.activities, protocol.seed, weights, shown)

    @cached_property
    def pairs(self) -> tuple[tuple[Tests, Tests], ...]:
        """The halves that both show some activity that counts."""
        counts = self.weights > 0
        return tuple((a, b) for a, b in self.halves if (a.trial.testable & b.trial.testable & counts).any())

    def weighed(self, weights: np.ndarray) -> SetTests:
        """The same tests by other weights of activities."""
        each = {self.whole, *chain.from_iterable(self.halves)}
        other = {one: replace(one, weights=weights, known=vars(one).get("alone", one.known)) for one in each}
        halves = tuple((other[a], other[b]) for a, b in self.halves)
        return replace(self, whole=other[self.whole], halves=halves, weights=weights, searches={})


def _held(source: PatchBlocks) -> np.ndarray:
    """Features (N, W, D) about their means, read once."""
    n_windows, n_patches, width = source.shape
    held = np.empty((n_patches, n_windows, width), dtype=np.float32)
    for span in spans(source, READ_BYTES):
        held[span] = source.patches(span).swapaxes(0, 1)
        held[span] -= held[span].mean(axis=1, keepdims=True)
    return held


def _evenly(activity: np.ndarray, clip: np.ndarray, is_test: np.ndarray, most: int) -> np.ndarray:
    """Rows of at most `most` windows, evenly over activities and clips, test windows first."""
    if len(activity) <= most:
        return np.arange(len(activity))
    rows = np.flatnonzero(is_test) if is_test.sum() >= most else np.arange(len(activity))
    rows = rows[np.lexsort((rows, clip[rows], activity[rows]))]
    return np.sort(rows[np.linspace(0, len(rows) - 1, most).astype(int)])
