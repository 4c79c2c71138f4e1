# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows of testable activities, dealt to trainings and tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .folds import ALWAYS_TRAIN, grouped_folds, subject_folds, untestable
from .halves import HALVINGS, Plan, plan


@dataclass(frozen=True, eq=False)
class Planned:
    """Windows of testable activities, and what is trained and tested on them.

    Attributes
    ----------
    used : ndarray of int, shape (U,)
        The windows, of all that were given.
    labels, fold : ndarray of int, shape (U,)
        Activity of each, of `activities`, and fold.
    is_test : ndarray of bool, shape (U,)
    plan : Plan
    activities : tuple of str
    left_out : dict of str to str
        Activities not tested, each with the reason.
    protocol : str
    """

    used: np.ndarray
    labels: np.ndarray
    fold: np.ndarray
    is_test: np.ndarray
    plan: Plan
    activities: tuple[str, ...]
    left_out: dict[str, str]
    protocol: str


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
    split = _split(activity, clip, subject, activities, folds, seed)
    index = {name: number for number, name in enumerate(split.tested)}
    used = np.flatnonzero(np.isin(activity, split.tested))
    labels = np.array([index[name] for name in activity[used].tolist()])
    fold, tested = split.fold[used], is_test[used]
    trials = plan(labels, clip[used], fold, tested, subject is not None, seed, halvings)
    return Planned(used, labels, fold, tested, trials, split.tested, split.left_out, split.protocol)


class _Split(NamedTuple):
    fold: np.ndarray
    tested: tuple[str, ...]
    left_out: dict[str, str]
    protocol: str


def _split(
    activity: np.ndarray,
    clip: np.ndarray,
    subject: np.ndarray | None,
    activities: Sequence[str],
    folds: int,
    seed: int,
) -> _Split:
    """Deal the windows of testable activities to folds; see `utility_map`."""
    left_out = untestable(activity, clip, activities)
    candidates = [name for name in activities if name not in left_out]
    rows = np.flatnonzero(np.isin(activity, candidates))
    if len(candidates) > 1:
        fold = np.full(len(activity), ALWAYS_TRAIN)
        if subject is not None:
            subject = np.asarray(subject)[rows]
            fold[rows] = subject_folds(subject, clip[rows])
            protocol = f"leave one of {len(np.unique(subject))} subjects out"
        else:
            n_folds = min(folds, len(np.unique(clip[rows])))
            fold[rows] = grouped_folds(activity[rows], clip[rows], n_folds, seed)
            protocol = f"{n_folds}-fold cross-validation grouped by clip"
        left_out |= untestable(activity, clip, candidates, fold)
        tested = tuple(name for name in candidates if name not in left_out)
        if len(tested) > 1:
            return _Split(fold, tested, left_out, protocol)
    raise ValueError(f"a utility map needs two activities that can be tested: {'; '.join(left_out.values())}")
