# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of F1 by activity and patch, in groups of activities, every cell with its interval."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from w2w.core.ranking.f1 import ClipUnits, clip_resamples, f1_scores
from w2w.core.ranking.utility import UtilityMap
from w2w.core.ranking.weights import mean_over

RESAMPLES = 1000


@dataclass(frozen=True, eq=False)
class ScoreRow:
    """An activity, or the mean over a group of them, at every patch of the table."""

    group: str  # group of the activity; empty in the mean over all
    activity: str  # empty in a mean
    f1: np.ndarray  # (n,)
    low: np.ndarray  # (n,)
    high: np.ndarray  # (n,)
    best: np.ndarray  # bool (n,): patches that cannot be told from the best of the row
    clips: int
    windows: int
    """Distinct motions and windows tested."""


def score_table(
    utility: UtilityMap,
    patches: Sequence[int],
    groups: Mapping[str, str],
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> list[ScoreRow]:
    """Rows of activities group by group, each group followed by its mean, then the mean over all that count.

    `patches`: patches of the table's columns.
    `groups`: group of each activity; those without stand in the last group, "".
    `resamples`: bootstrap resamples of the clips, the same for all patches and rows, so that the difference
    of two patches has an interval of its own.
    There is no row of means for a group of one activity, or if there is one group.
    """
    n_activities = len(utility.activities)
    named = utility.predictions[:, list(patches)]
    f1, samples = resampled_f1(utility.truth, named, utility.clip, n_activities, resamples, seed)
    group_of = [groups.get(name, "") for name in utility.activities]

    def row(group: str, activity: str, columns: list[int]) -> ScoreRow:
        tested = np.isin(utility.truth, columns)
        weights = utility.weights[columns]
        score, spread = mean_over(f1[:, columns], weights), mean_over(samples[:, :, columns], weights)
        tail = [(1 - utility.level) / 2, (1 + utility.level) / 2]
        low, high = np.quantile(spread, tail, axis=0)
        behind = np.quantile(spread - spread[:, [int(score.argmax())]], tail[1], axis=0)
        clips = len(np.unique(utility.clip[tested]))
        return ScoreRow(group, activity, score, low, high, behind >= 0, clips, int(tested.sum()))

    rows = []
    names = sorted(set(group_of), key=lambda name: (name == "", name))
    for group in names:
        members = [column for column, name in enumerate(group_of) if name == group]
        rows += [row(group, utility.activities[column], [column]) for column in members]
        if len(members) > 1 and len(names) > 1 and utility.counts[members].any():
            rows.append(row(group, "", members))
    rows.append(row("", "", list(range(n_activities))))
    return rows


def resampled_f1(
    truth: np.ndarray,
    predictions: np.ndarray,
    clip: np.ndarray,
    n_activities: int,
    n_resamples: int,
    seed: int,
) -> tuple[np.ndarray, np.ndarray]:
    """F1 of a few patches, and of every resample of the clips, for your own intervals.

    `truth`, `predictions`, `clip`, `n_activities`, `n_resamples`, `seed`: as for `score_patches`; with the
    same seed the same clips are drawn.
    Returns `f1` (N, A); `samples` (n_resamples, N, A): the same clips are drawn at all patches: a difference
    of two has an interval of its own.
    """
    counts = ClipUnits(truth, clip, n_activities).count(predictions)
    drawn = clip_resamples(counts.activity, n_resamples, np.random.default_rng(seed))
    return f1_scores(counts, np.ones((1, len(counts.size))))[0], f1_scores(counts, drawn)
