# SPDX-License-Identifier: GPL-3.0-or-later
"""What the report's page needs to choose sensors anew: exact scores, and what a designer's words mean."""

from __future__ import annotations

from typing import Any

import numpy as np

from w2w.core.patches.body_parts import ALL, MIDDLE, PARTS, SIDES, find_patches
from w2w.core.patches.patches import PatchSet
from w2w.core.patches.products import PLACEMENTS
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.subsets import ROUNDING, TIE

from .report_data import packed, title


def choice_data(utility: UtilityMap, patches: PatchSet, target: float, most: int | None) -> dict[str, Any]:
    """Everything the page chooses by.

    Parameters
    ----------
    utility : UtilityMap
    patches : PatchSet
    target : float
        Mean-max F1 that the run asked for.
    most : int, optional
        Most sensors that the run allowed.

    Returns
    -------
    dict
        Plain values; the F1 (N, A) as the bits of its single-precision numbers, so that equal patches
        stay equal.
    """
    return {
        "activities": [title(name) for name in utility.activities],
        "weights": utility.weights.tolist(),
        "f1": packed(np.ascontiguousarray(utility.f1, dtype=np.float32).view(np.uint32).ravel(), "uint32"),
        "words": words_of(patches),
        "target": target,
        "most": "" if most is None else most,
        "rounding": ROUNDING,
        "tie": TIE,
    }


def words_of(patches: PatchSet) -> dict[str, list[int]]:
    """The patches that each word of a wish means, for all that has any: sides, parts, placements, regions."""
    stems = [*PARTS, *(placement.name for placement in PLACEMENTS), *ALL]
    words = [*SIDES, MIDDLE, *(f"{side}{stem}" for stem in stems for side in ("", "left ", "right "))]
    found = {}
    for word in dict.fromkeys(words):
        try:
            meant = find_patches(patches.regions, patches.names, word)
        except ValueError:  # one side of what has no sides
            continue
        if len(meant):
            found[word] = np.unique(meant).tolist()
    return found
