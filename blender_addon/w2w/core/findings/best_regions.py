# SPDX-License-Identifier: GPL-3.0-or-later
"""The best regions of the body, each by its best patch: the one table of them."""

from __future__ import annotations

from typing import Any

from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap

AT_MOST = 10
"""Regions listed."""


def best_regions(utility: UtilityMap, patches: PatchSet, count: int = AT_MOST) -> list[dict[str, Any]]:
    """The best patch of each region by expected F1, with its scores, best region first."""
    return [
        {
            "patch": patch,
            "name": patches.names[patch],
            "expected": float(utility.expected_mean[patch]),
            "low": float(utility.expected_low[patch]),
            "high": float(utility.expected_high[patch]),
            "as_good": bool(utility.as_good[patch]),
            "f1": float(utility.mean[patch]),
            "f1_low": float(utility.mean_low[patch]),
            "f1_high": float(utility.mean_high[patch]),
        }
        for patch in patches.best_of_regions(utility.expected_mean)[:count]
    ]
