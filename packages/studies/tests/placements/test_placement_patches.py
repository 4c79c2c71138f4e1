# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches that represent the paper's placements."""

from __future__ import annotations

import numpy as np
import pytest

from w2w.core.patches.body_parts import PLACEMENTS, SIDES
from w2w.core.patches.naming import place, resolve
from w2w.core.patches.patches import sample_patches
from w2w_studies.placements.placement_patches import placement_patches


@pytest.mark.parametrize("side", SIDES)
def test_the_eleven_placements_are_eleven_patches_near_their_places(bundled_body, side) -> None:
    patches = sample_patches(bundled_body)
    found = placement_patches(bundled_body, patches, side)
    assert len({near.patch for near in found.values()}) == len(found) == 11
    for one in PLACEMENTS:
        centre = bundled_body.vertices[place(one.on(side), bundled_body)]
        away = np.linalg.norm(bundled_body.vertices[patches.vertices] - centre, axis=1)
        patch, away_m = found[one.name]
        assert away_m == pytest.approx(away[patch])
        assert away_m < min(0.05, away.min() + 0.01)  # the nearest over the skin, or nearly
        named = f"{side} {one.name}" if one.sided else one.name
        assert patch == resolve(named, bundled_body, patches)
