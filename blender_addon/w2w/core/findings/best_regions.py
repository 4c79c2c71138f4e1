# SPDX-License-Identifier: GPL-3.0-or-later
"""The best regions of the body, each by its best place: the one table of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap

AT_MOST = 10
"""Regions listed."""


def best_regions(utility: UtilityMap, patches: PatchSet, count: int = AT_MOST) -> list[dict[str, Any]]:
    """The best place of each region by mean F1 with its intervals, best region first."""
    best: dict[str, int] = {}
    for patch in np.argsort(-utility.mean, kind="stable").tolist():
        best.setdefault(patches.regions[patch], patch)
    return [
        {
            "patch": patch,
            "place": patches.names[patch],
            "f1": float(utility.mean[patch]),
            "low": float(utility.mean_low[patch]),
            "high": float(utility.mean_high[patch]),
            "rank": (int(utility.rank_low[patch]), int(utility.rank_high[patch])),
        }
        for patch in list(best.values())[:count]
    ]
