# SPDX-License-Identifier: GPL-3.0-or-later
"""Is one patch better than another? Differences of F1 with intervals, both seeing the same clips."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from w2w.core.ranking.utility import UtilityMap
from w2w.core.ranking.weights import mean_over

from .score_table import resampled_f1

RESAMPLES = 1000


@dataclass(frozen=True, eq=False)
class PatchDifference:
    """How much better some patches are than others at some activities."""

    f1: np.ndarray  # (P,): mean F1 over the activities at each of the patches
    other_f1: np.ndarray  # (Q,)
    difference: np.ndarray
    low: np.ndarray
    high: np.ndarray
    """(P, Q): mean F1 of a patch less that of another, and its interval."""

    def verdicts(self) -> np.ndarray:
        """1 where a patch is better, -1 where it is worse, 0 where the difference may be chance; (P, Q)."""
        return (self.low > 0).astype(int) - (self.high < 0).astype(int)


def compare_patches(
    utility: UtilityMap,
    patches: Sequence[int],
    others: Sequence[int],
    activities: Sequence[str] = (),
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> PatchDifference:
    """Compare every patch of one list with every patch of another.

    `patches`, `others`: P and Q patches.
    `activities`: activities to average over, of those tested; all of them by default.
    `resamples`: bootstrap resamples of the clips, the same for all patches: a difference of two patches has
    an interval of its own, narrower than theirs.
    Raises ValueError if none of the activities was tested.
    """
    columns = [n for n, name in enumerate(utility.activities) if not activities or name in activities]
    if not columns:
        raise ValueError(f"none of these activities was tested: {', '.join(activities)}")
    every = [*patches, *others]
    named = utility.predictions[:, every]
    f1, drawn = resampled_f1(utility.truth, named, utility.clip, len(utility.activities), resamples, seed)
    weights = utility.weights[columns]
    weights = weights if weights.any() else np.ones(len(columns))  # background, asked for by name
    mean, samples = mean_over(f1[:, columns], weights), mean_over(drawn[:, :, columns], weights)
    first, second = samples[:, : len(patches)], samples[:, len(patches) :]
    tail = (1 - utility.level) / 2
    low, high = np.quantile(first[:, :, None] - second[:, None], [tail, 1 - tail], axis=0)
    f1, other = mean[: len(patches)], mean[len(patches) :]
    return PatchDifference(f1, other, f1[:, None] - other, low, high)
