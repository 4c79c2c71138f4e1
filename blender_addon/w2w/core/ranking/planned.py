# SPDX-License-Identifier: GPL-3.0-or-later
"""The protocol of training and testing, and windows dealt by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .folds import deal
from .halves import HALVINGS, Plan, plan
from .weights import weights_of


@dataclass(frozen=True, eq=False)
class Protocol:
    """Training and testing of W windows, never on the same clip.

    Clips that are one motion, and augmented copies of a clip, must bear one name
    (`same_motion.same_motion_groups`). Windows of other activities than `activities` are not used. `seed`
    decides the folds, the bootstrap's draws and those of a classifier given by name.
    """

    activity: np.ndarray  # (W,), of str
    clip: np.ndarray  # (W,)
    subject: np.ndarray | None  # (W,), of str; where given, one is left out at a time, not a fold of clips
    is_test: np.ndarray  # (W,), bool: neither overlapping nor augmented; the others are for training only
    activities: Sequence[str]  # in the order wanted
    folds: int = 5  # where no subjects are given; fewer when there are fewer clips
    seed: int = 0
    counts: Mapping[str, float] | None = None  # weights in the means, 1 by default; 0 is trained against only

    def planned(self, halvings: int = HALVINGS) -> Planned:
        """Deal the windows to trainings and tests.

        Raises
        ------
        ValueError
            If fewer than two activities can be tested, or none of them counts; the message says why.
        """
        activity, clip, is_test = (
            np.asarray(self.activity),
            np.asarray(self.clip),
            np.asarray(self.is_test, bool),
        )
        split = deal(activity, clip, self.subject, self.activities, self.folds, self.seed)
        index = {name: number for number, name in enumerate(split.tested)}
        used = np.flatnonzero(np.isin(activity, split.tested))
        labels = np.array([index[name] for name in activity[used].tolist()])
        fold, tested = split.fold[used], is_test[used]
        trials = plan(labels, clip[used], fold, tested, self.subject is not None, self.seed, halvings)
        weights = weights_of(split.tested, self.counts)
        return Planned(
            used, labels, fold, tested, trials, split.tested, weights, split.left_out, split.protocol
        )


@dataclass(frozen=True, eq=False)
class Planned:
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

    def among(self, rows: np.ndarray) -> Planned:
        """The same on some of the windows, by their places in `used`, for choosing sets (`Plan.among`)."""
        labels = self.labels[rows]
        return replace(
            self,
            used=self.used[rows],
            labels=labels,
            fold=self.fold[rows],
            is_test=self.is_test[rows],
            plan=self.plan.among(rows, labels),
        )
