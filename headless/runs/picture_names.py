# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pictures of a study are called."""

from __future__ import annotations

from collections.abc import Sequence

from w2w.core.motion.library import unique_names

HEATMAPS = "heatmaps"
"""The folder they lie in."""

MEAN, SUBSET = "mean", "subset"


def picture_names(activities: Sequence[str]) -> list[str]:
    """File names of the activities' pictures, distinct from each other and from the other two."""
    names = unique_names([MEAN, SUBSET, *(f"{activity}." for activity in activities)])
    return names[2:]


def picture_files(activities: Sequence[str]) -> list[str]:
    """The files of a study's pictures, in their folder."""
    return [f"{name}.png" for name in (MEAN, SUBSET, *picture_names(activities))]
