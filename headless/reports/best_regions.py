# SPDX-License-Identifier: GPL-3.0-or-later
"""The best regions of the body, each by its best place: the one table of them."""

from __future__ import annotations

from typing import Any

from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap

AT_MOST = 10
"""Regions listed."""


def best_regions(utility: UtilityMap, patches: PatchSet, count: int = AT_MOST) -> list[dict[str, Any]]:
    """The best place of each region by mean F1 with its intervals, best region first."""
    return [
        {
            "patch": patch,
            "place": patches.names[patch],
            "f1": float(utility.mean[patch]),
            "low": float(utility.mean_low[patch]),
            "high": float(utility.mean_high[patch]),
            "rank": (int(utility.rank_low[patch]), int(utility.rank_high[patch])),
        }
        for patch in patches.best_of_regions(utility.mean)[:count]
    ]
