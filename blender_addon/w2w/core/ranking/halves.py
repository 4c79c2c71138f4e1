# SPDX-License-Identifier: GPL-3.0-or-later
"""The protocol of a ranking: trainings and tests on all clips and on disjoint halves of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np

from .folds import ALWAYS_TRAIN, deal, grouped_folds
from .weights import weights_of

HALVINGS = 4
"""Ways in which the clips, or many subjects, are halved."""

REPEATS = 2
"""Cross-validations on all clips, each with folds of its own: the F1 expected is by their mean.

With one, which of several equal products came first hung on the seed of the folds.
"""

SET_HALVINGS = 2
"""Halvings that sets are chosen by: each half chooses sets of its own, which takes most of the time."""

ALL_WAYS = 10
"""Subjects are halved in every way where there are no more: up to six of them."""

FEWEST_SUBJECTS = 4
"""Subjects from which on each half has two, to train on one and test on the other."""


class Split(NamedTuple):
    """One training: the blocks that it sees and the windows that it is tested on."""

    train: np.ndarray
    tested: np.ndarray


class Predictions(NamedTuple):
    """Activities that one or several models predict for some of the windows that a split tests."""

    split: int  # its number in the plan
    windows: np.ndarray  # (v,), int
    activities: np.ndarray  # (models, v), int


@dataclass(frozen=True, eq=False)
class Trial:
    """A cross-validation on some of the clips.

    In `weight`, the windows of a clip (a subject where subjects are left out) share one vote, and the clips
    of an activity share one.
    """

    splits: tuple[int, ...]  # of the plan, one a fold
    windows: np.ndarray  # (V,), int: those tested, split by split
    testable: np.ndarray  # (A,), bool: activities with clips in two folds, so that those tested were trained
    weight: np.ndarray  # (V,)


@dataclass(frozen=True, eq=False)
class Plan:
    """All trainings and tests of a ranking.

    The maps of `pairs` are compared: disjoint halves of the clips, or single subjects of two or three. The
    variance of the whole map is the mean square of a pair's difference over `shrink`.
    """

    block: np.ndarray  # (W,), int: windows of one block are always trained on or tested on together
    splits: tuple[Split, ...]
    whole: Trial  # the cross-validation on all clips
    repeats: tuple[Trial, ...]  # others, with other folds
    pairs: tuple[tuple[Trial, Trial], ...]
    disjoint: bool  # no clip that one of a pair is trained or tested on is trained on by the other
    shrink: float
    clips: np.ndarray  # (A,), int: clips (subjects, where those are left out) that show each activity
    vote: np.ndarray  # (W,), int: clip (subject) of each window

    @property
    def trials(self) -> tuple[Trial, ...]:
        """All trials, each once, the whole first and its repeats after it."""
        return (self.whole, *self.repeats, *dict.fromkeys(trial for pair in self.pairs for trial in pair))

    def pairs_to_choose_by(self) -> tuple[tuple[Trial, Trial], ...]:
        """The pairs by which sets are chosen: the first halvings, or all pairs of single subjects."""
        return self.pairs[:SET_HALVINGS] if self.disjoint else self.pairs

    def among(self, rows: np.ndarray, labels: np.ndarray) -> Plan:
        """The same trainings and tests on the windows `rows` (R,), ascending, of activities `labels` (R,).

        Its pairs are those by which sets are chosen.
        """
        block, vote = self.block[rows], self.vote[rows]
        place = np.full(len(self.block), -1)
        place[rows] = np.arange(len(rows))

        def kept(windows: np.ndarray) -> np.ndarray:
            places = place[windows]
            return places[places >= 0]

        splits = tuple(Split(split.train, kept(split.tested)) for split in self.splits)

        def smaller(trial: Trial) -> Trial:
            tested = tuple(number for number in trial.splits if len(splits[number].tested))
            windows = kept(trial.windows)
            testable = trial.testable & np.isin(np.arange(len(trial.testable)), labels[windows])
            return Trial(tested, windows, testable, _votes(labels, vote, windows))

        few = replace(self, pairs=self.pairs_to_choose_by(), repeats=())
        trials = {trial: smaller(trial) for trial in few.trials}
        pairs = tuple((trials[a], trials[b]) for a, b in few.pairs)
        return replace(
            self, block=block, splits=splits, whole=trials[self.whole], repeats=(), pairs=pairs, vote=vote
        )


def plan(
    labels: np.ndarray,
    clip: np.ndarray,
    fold: np.ndarray,
    is_test: np.ndarray,
    by_subject: bool = False,
    seed: int = 0,
    halvings: int = HALVINGS,
    refolded: Sequence[np.ndarray] = (),
) -> Plan:
    """Plan the trainings and tests of a ranking.

    For each window, (W,): `labels` are its activity, 0 to A - 1; `clip` is never split between halves; `fold`
    is -1 if every fold trains on it; `is_test` marks test windows. If folds are subjects, these are halved,
    not the clips. 0 halvings plan the whole alone. `refolded` are other folds, each (W,).
    """
    sides = _halve_subjects(fold, seed, halvings) if by_subject else deal_halves(labels, clip, seed, halvings)
    cells = np.stack([fold, *sides, *refolded], axis=1)
    kinds, block = np.unique(cells, axis=0, return_inverse=True)
    block = block.ravel()
    tested = [f for f in np.unique(fold[is_test]) if f != ALWAYS_TRAIN]
    vote = fold if by_subject else np.unique(clip, return_inverse=True)[1]
    clips = np.bincount(np.unique(np.stack([labels, vote]), axis=1)[0], minlength=labels.max() + 1)
    splits: list[Split] = []

    def trial(of_side: np.ndarray, among: np.ndarray, column: int = 0) -> Trial:
        first, fold = len(splits), cells[:, column]
        for f in tested:
            test, train = among & (fold == f) & is_test, of_side & (kinds[:, column] != f)
            if test.any() and train.any():
                splits.append(Split(np.flatnonzero(train), np.flatnonzero(test)))
        windows = np.concatenate([np.empty(0, dtype=np.int64), *(split.tested for split in splits[first:])])
        testable = _in_two_folds(labels, fold, among)
        return Trial(tuple(range(first, len(splits))), windows, testable, _votes(labels, vote, windows))

    everything = np.ones(len(kinds), dtype=bool)
    whole, *repeats = (
        trial(everything, np.ones(len(fold), dtype=bool), column)
        for column in (0, *range(1 + len(sides), cells.shape[1]))
    )
    if by_subject and halvings and not sides:
        single = _single_folds(labels, vote, whole, splits)
        return Plan(block, tuple(splits), whole, (), single, False, 2.0 * len(tested), clips, vote)
    pairs, always = [], kinds[:, 0] == ALWAYS_TRAIN
    for number, side in enumerate(sides, start=1):
        if (_in_two_folds(labels, fold, side) & _in_two_folds(labels, fold, ~side)).any():
            first, second = (trial(always | (kinds[:, number] == s), side == s) for s in (False, True))
            pairs.append((first, second))
    return Plan(block, tuple(splits), whole, tuple(repeats), tuple(pairs), True, 4.0, clips, vote)


def _single_folds(
    labels: np.ndarray, vote: np.ndarray, whole: Trial, splits: Sequence[Split]
) -> tuple[tuple[Trial, Trial], ...]:
    """Pairs of the whole's folds, each as a trial."""
    activities = np.arange(len(whole.testable))
    alone = []
    for number in whole.splits:
        windows = splits[number].tested
        shown = np.isin(activities, labels[windows]) & whole.testable
        alone.append(Trial((number,), windows, shown, _votes(labels, vote, windows)))
    return tuple(pair for pair in combinations(alone, 2) if (pair[0].testable & pair[1].testable).any())


def deal_halves(labels: np.ndarray, clip: np.ndarray, seed: int, halvings: int) -> list[np.ndarray]:
    """Deal half of each activity's clips to one side, shape (W,), bool, in each of the halvings.

    A clip of several activities goes with the first of them.
    """
    rng = np.random.default_rng([seed, 1])
    sides = []
    for _ in range(halvings):
        side = np.zeros(len(clip), dtype=bool)
        taken: set = set()
        for label in range(labels.max() + 1):
            clips = [name for name in np.unique(clip[labels == label]).tolist() if name not in taken]
            taken.update(clips)
            rng.shuffle(clips)
            half = (len(clips) + int(rng.integers(2))) // 2
            side |= np.isin(clip, clips[:half])
        sides.append(side)
    return sides


def _halve_subjects(fold: np.ndarray, seed: int, halvings: int) -> list[np.ndarray]:
    """Deal half of the subjects to one side, differently each time; [] if a half would have one subject."""
    subjects = np.unique(fold[fold != ALWAYS_TRAIN])
    if len(subjects) < FEWEST_SUBJECTS:
        return []
    rng = np.random.default_rng([seed, 2])
    ways = comb(len(subjects), len(subjects) // 2) // (2 - len(subjects) % 2)
    halvings = ways if HALVINGS <= halvings < ways <= ALL_WAYS else halvings
    chosen: list[frozenset] = []
    for _ in range(30 * halvings):
        half = frozenset(rng.permutation(subjects)[: len(subjects) // 2].tolist())
        others = frozenset(subjects.tolist()) - half
        if half not in chosen and others not in chosen and len(chosen) < halvings:
            chosen.append(half)
    return [np.isin(fold, list(half)) for half in chosen]


def _in_two_folds(labels: np.ndarray, fold: np.ndarray, among: np.ndarray) -> np.ndarray:
    folds = (np.unique(fold[among & (labels == label)]) for label in range(labels.max() + 1))
    return np.array([len(distinct) > 1 for distinct in folds])


def _votes(labels: np.ndarray, vote: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Share of each window in its activity, whose clips or subjects have a vote each."""
    n_votes = vote.max() + 1
    pairs = labels[windows] * n_votes + vote[windows]
    units, unit, size = np.unique(pairs, return_inverse=True, return_counts=True)
    units_of = np.bincount(units // n_votes)
    return 1.0 / size[unit] / units_of[labels[windows]]


def maps_of(values: np.ndarray, plan: Plan) -> Sequence[tuple[np.ndarray, np.ndarray]]:
    """The maps (A, N) of each pair, from those of all trials (trials, A, N)."""
    by_trial = dict(zip(plan.trials, values, strict=True))
    return [(by_trial[first], by_trial[second]) for first, second in plan.pairs]


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """Training and testing of W windows, never on the same clip.

    Clips that are one motion, and augmented copies of a clip, must bear one name
    (`same_motion.same_motion_groups`). Windows of other activities than `activities` are not used. `seed`
    decides the folds, the bootstrap's draws and those of a classifier given by name.
    """

    activity: np.ndarray  # (W,), of str
    clip: np.ndarray  # (W,)
    subject: np.ndarray | None  # (W,), of str; where given, one is left out at a time, not a fold of clips
    is_test: np.ndarray  # (W,), bool: test windows, which do not overlap; the others only train
    activities: Sequence[str]  # in the order wanted
    folds: int = 5  # where no subjects are given; fewer when there are fewer clips
    seed: int = 0
    counts: Mapping[str, float] | None = None  # weights in the means, 1 by default; 0 is trained against only

    def plan(self, halvings: int = HALVINGS) -> TrialPlan:
        """Deal the windows to trainings and tests.

        Raises
        ------
        ValueError
            If fewer than two activities can be tested, or none of them counts; the message says why.
        """
        activity = np.asarray(self.activity)
        clip = np.unique(self.clip, return_inverse=True)[1]  # numbers are compared faster than names
        is_test = np.asarray(self.is_test, bool)
        fold, activities, left_out, protocol = deal(
            activity, clip, self.subject, self.activities, self.folds, self.seed
        )
        index = {name: number for number, name in enumerate(activities)}
        used = np.flatnonzero(np.isin(activity, activities))
        labels = np.array([index[name] for name in activity[used].tolist()])
        fold, is_test = fold[used], is_test[used]
        refolded = []
        if halvings and self.subject is None:
            refolded = [
                grouped_folds(labels, clip[used], fold.max() + 1, self.seed + number)
                for number in range(1, REPEATS)
            ]
        trials = plan(
            labels, clip[used], fold, is_test, self.subject is not None, self.seed, halvings, refolded
        )
        weights = weights_of(activities, self.counts)
        return TrialPlan(used, labels, fold, is_test, trials, activities, weights, left_out, protocol)


@dataclass(frozen=True, eq=False)
class TrialPlan:
    """Windows of testable activities, and the trainings and tests on them."""

    used: np.ndarray  # (U,), int: the windows, of all that were given
    labels: np.ndarray  # (U,), int: activity of each, of `activities`
    fold: np.ndarray  # (U,), int
    is_test: np.ndarray  # (U,), bool
    plan: Plan
    activities: tuple[str, ...]
    weights: np.ndarray  # (A,): what each activity counts
    left_out: dict[str, str]  # activities not tested, each with the reason
    protocol: str  # in words

    def among(self, rows: np.ndarray) -> TrialPlan:
        """The plan on some of the windows, by their places in `used`, for choosing sets (`Plan.among`)."""
        labels = self.labels[rows]
        some = {name: getattr(self, name)[rows] for name in ("used", "fold", "is_test")}
        return replace(self, **some, labels=labels, plan=self.plan.among(rows, labels))
