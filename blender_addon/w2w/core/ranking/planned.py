# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows of testable activities, dealt to trainings and tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .folds import deal
from .halves import HALVINGS, Plan, plan


@dataclass(frozen=True, eq=False)
class Planned:
    """Windows of testable activities, and the trainings and tests on them."""

    used: np.ndarray  # (U,), int: the windows, of all that were given
    labels: np.ndarray  # (U,), int: activity of each, of `activities`
    fold: np.ndarray  # (U,), int
    is_test: np.ndarray  # (U,), bool
    plan: Plan
    activities: tuple[str, ...]
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


def planned(
    activity: np.ndarray,
    clip: np.ndarray,
    subject: np.ndarray | None,
    is_test: np.ndarray,
    activities: Sequence[str],
    folds: int = 5,
    seed: int = 0,
    halvings: int = HALVINGS,
) -> Planned:
    """Deal windows to trainings and tests.

    Parameters and errors are those of `utility_map`.
    """
    activity, clip, is_test = np.asarray(activity), np.asarray(clip), np.asarray(is_test, dtype=bool)
    split = deal(activity, clip, subject, activities, folds, seed)
    index = {name: number for number, name in enumerate(split.tested)}
    used = np.flatnonzero(np.isin(activity, split.tested))
    labels = np.array([index[name] for name in activity[used].tolist()])
    fold, tested = split.fold[used], is_test[used]
    trials = plan(labels, clip[used], fold, tested, subject is not None, seed, halvings)
    return Planned(used, labels, fold, tested, trials, split.tested, split.left_out, split.protocol)
