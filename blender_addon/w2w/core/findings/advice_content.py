# SPDX-License-Identifier: GPL-3.0-or-later
"""A choice of sensors as plain values on file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..files import DIGITS
from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap
from ..selection.advice import Advice
from ..selection.headline import (
    as_good_as,
    best_spot_sentence,
    confidence_sentence,
    mean_sentence,
    more_clips,
    where_to_wear,
)
from ..selection.joint import JointSet
from ..selection.promise import Promise
from ..selection.subsets import Subset
from .counts import interval_caution
from .joint import joint_content


def advice_content(
    advice: Advice,
    utility: UtilityMap,
    patches: PatchSet,
    together: Sequence[UtilityMap],
    worn: JointSet | None = None,
) -> dict[str, Any]:
    """The choice as plain values."""
    return {
        "best_single_patch": {
            **patch_content(advice.best, utility, patches),
            "where": where_to_wear(advice.best, utility, patches, advice.allowed),
            "sentence": best_spot_sentence(advice.best, utility, patches, advice.allowed),
            "indistinguishable_patches": len(as_good_as(advice.best, utility, advice.allowed)) - 1,
            "clips_rank_placements": utility.can_rank,
            "chance_of_gain": round(utility.beats_average, 3),
        },
        "mean": {
            "weights": dict(zip(utility.activities, utility.weights.tolist(), strict=True)),
            "sentence": mean_sentence(utility),
        },
        "map_reliability": None if np.isnan(utility.reliability) else _f1(utility.reliability),
        "more_clips_per_activity": more_clips(utility),
        "map_sentence": confidence_sentence(utility, advice.best),
        "interval_caution": interval_caution(utility),
        "worn_together": None if worn is None else worn_content(worn, utility, patches),
        "joint": joint_of(advice, together),
        "subset": {
            **subset_content(advice.subset, utility, patches),
            "alternatives": [[patches.names[patch] for patch in equals] for equals in advice.alternatives],
        },
        "exact": None
        if advice.exact is None
        else {
            **subset_content(advice.exact, utility, patches),
            "proven": advice.exact.proven,
        },
        "greedy_and_exact": advice.gap_sentence(),
        "next_sensor": None
        if advice.next_patch < 0
        else {
            "patch": advice.next_patch,
            "name": patches.names[advice.next_patch],
            "gain": _f1(advice.next_gain),
        },
        "together": together_content(together, advice.subset.promise),
    }


def worn_content(worn: JointSet, utility: UtilityMap, patches: PatchSet) -> dict[str, Any]:
    """Patches chosen to be worn together, with what the first, the first two, and so on would reach."""
    made = worn.promise
    return {
        "sentence": worn.sentence(),
        "target": worn.target,
        "every_activity": worn.every_activity,
        "reached": worn.reached,
        "cost": worn.cost,
        **expected_content(made, len(worn.order)),
        "f1": {name: _f1(value) for name, value in zip(worn.activities, made.f1[-1], strict=True)},
        "places": [
            {
                **patch_content(patch, utility, patches),
                **expected_content(made, number, "_so_far"),
                "mean_f1_so_far": _f1(worn.raw_mean[number - 1]),
            }
            for number, patch in enumerate(worn.order, start=1)
        ],
        "next_sensor": next_worn(worn, patches),
    }


def next_worn(worn: JointSet, patches: PatchSet) -> dict[str, Any] | None:
    """What goes best with a set; None where no more sensors are allowed."""
    made = worn.with_next
    if made is None:
        return None
    name = patches.names[worn.further[0]]
    return {
        "patch": worn.further[0],
        "name": name,
        **expected_content(made, len(made.mean)),
        "sentence": f"the best sensor to add is {name}; with it, the set reaches {made.text()}",
    }


def expected_content(made: Promise | None, sensors: int, suffix: str = "") -> dict[str, Any]:
    """What the first so many sensors of a set would reach on other clips; None where it is not known."""
    name = f"expected_f1{suffix}"
    if made is None:
        return {name: None, f"{name}_interval": None}
    interval = [_f1(made.low[sensors - 1]), _f1(made.high[sensors - 1])]
    return {name: _f1(made.mean[sensors - 1]), f"{name}_interval": interval}


def subset_content(subset: Subset, utility: UtilityMap, patches: PatchSet) -> dict[str, Any]:
    """A set of sensors with what it would reach on other clips, and its reach by the proxy on these."""
    made = subset.promise
    return {
        **expected_content(made, len(subset.order)),
        "expected_sentence": subset.expected_sentence(),
        "target": subset.target,
        "reached": subset.reached,
        "sentence": subset.proxy_sentence(),
        "best_reachable": _f1(subset.best_reachable),
        "cost": subset.cost,
        "places": [
            {
                **patch_content(patch, utility, patches),
                **expected_content(made, number, "_so_far"),
                "mean_max_f1_so_far": _f1(value),
            }
            for number, (patch, value) in enumerate(
                zip(subset.order, subset.mean_max_after_each, strict=True), start=1
            )
        ],
    }


def patch_content(patch: int, utility: UtilityMap, patches: PatchSet) -> dict[str, Any]:
    """One patch by number, name, region and vertex, with its scores."""
    return {
        "patch": int(patch),
        "name": patches.names[patch],
        "region": patches.regions[patch],
        "vertex": int(patches.vertices[patch]),
        "mean_f1": _f1(utility.mean[patch]),
        "mean_f1_interval": [_f1(utility.mean_low[patch]), _f1(utility.mean_high[patch])],
        "expected_f1": _f1(utility.expected_mean[patch]),
        "expected_f1_interval": [_f1(utility.expected_low[patch]), _f1(utility.expected_high[patch])],
        "rank_interval": [int(utility.rank_low[patch]), int(utility.rank_high[patch])],
        "f1": {name: _f1(value) for name, value in zip(utility.activities, utility.f1[patch], strict=True)},
    }


def together_content(together: Sequence[UtilityMap], made: Promise | None = None) -> list[dict[str, Any]]:
    """What one classifier on the first sensor, the first two, and so on would reach, and reached here."""
    return [
        {
            "sensors": number,
            "classifier": tested.classifier,
            **expected_content(made, number),
            "mean_f1": _f1(tested.mean[0]),
            "mean_f1_interval": [_f1(tested.mean_low[0]), _f1(tested.mean_high[0])],
            "f1": {name: _f1(value) for name, value in zip(tested.activities, tested.f1[0], strict=True)},
        }
        for number, tested in enumerate(together, start=1)
    ]


def joint_of(advice: Advice, together: Sequence[UtilityMap]) -> dict[str, Any] | None:
    """What the chosen sensors reach together; None where they were not tested so."""
    subset = advice.subset
    tested = together_content(together, subset.promise)
    return joint_content(tested, subset.target, len(subset.order), advice.least)


def _f1(value: float) -> float:
    return round(float(value), DIGITS)
