# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches that represent the paper's 11 placements."""

import warnings
from collections.abc import Callable

from w2w.core.body.body import Body
from w2w.core.patches.body_parts import PLACEMENTS
from w2w.core.patches.naming import DEFAULT_SIDE, Nearest, nearest
from w2w.core.patches.patches import PatchSet

UNUSUAL = ("posterior scapula", "lower spine", "lateral oblique")
"""Placements at which wearables are seldom worn."""


def placement_patches(
    body: Body, patches: PatchSet, side: str = DEFAULT_SIDE, say: Callable[[str], object] = warnings.warn
) -> dict[str, Nearest]:
    """Patch of each of the 11 placements on one side of the body, by its name, where one is near enough.

    `say` is given the reasons why placements are left out; a ValueError if all are.
    """
    found = {}
    for one in PLACEMENTS:
        try:
            found[one.name] = nearest(one.name, one.on(side), body, patches, say)
        except ValueError as too_far:
            if one is PLACEMENTS[-1] and not found:
                raise
            say(str(too_far))
    return found
