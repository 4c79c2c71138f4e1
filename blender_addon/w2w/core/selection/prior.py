# SPDX-License-Identifier: GPL-3.0-or-later
"""What is generally good: how places do in libraries of motion clips, which a choice leans on."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..body.body import template
from ..patches.body_parts import side_of
from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap

WEIGHT = 0.5
"""Share of the prior that is added to the F1 expected from the clips themselves (docs/evidence/habit.md)."""

GENERAL: Mapping[str, float] = template("prior.json")["regions"]
"""F1 above an average place, by region without its side: of libraries that `w2w study prior` read."""


def prior_at(regions: Sequence[str], general: Mapping[str, float] = GENERAL) -> np.ndarray:
    """F1 above an average patch that other libraries show at patches of these regions (N,); 0 if unknown."""
    above = np.array([general.get(side_of(region)[1], 0.0) for region in regions])
    return above - above.mean()


def leaning(utility: UtilityMap, patches: PatchSet, general: Mapping[str, float] = GENERAL) -> UtilityMap:
    """The map that a choice goes by: F1 expected from its clips, moved towards what is generally good."""
    more = (WEIGHT * prior_at(patches.regions, general)).astype(np.float32)
    moved = {name: np.clip(getattr(utility, name) + more, 0, 1) for name in EXPECTED}
    return replace(utility, expected_f1=np.clip(utility.expected_f1 + more[:, None], 0, 1), **moved)


EXPECTED = ("expected_mean", "expected_low", "expected_high")
"""Fields of a map that are moved."""
