# SPDX-License-Identifier: GPL-3.0-or-later
"""A made library of several sources for tests."""

import numpy as np

from w2w.core.windows.inputs import ArrayBlocks
from w2w_studies.validation.within_sources import MixedWindows

PATCHES, GOOD = 12, 4
"""Of so many patches the first few tell activities apart."""


def windows(activities_of, performers=4, clips=3, source_shift=0.0, signal=2.5, seed=0):
    """Each performer shows each activity of their source some times; sources differ by a shift."""
    rng = np.random.default_rng(seed)
    rows = [
        (activity, source, f"{source} {who}", f"{source} {who} {activity} {clip}")
        for source, activities in activities_of.items()
        for activity in activities
        for who in range(performers)
        for clip in range(clips)
    ]
    activity, source, performer, motion = np.array(rows).T
    features = rng.normal(size=(len(rows), PATCHES, 8)).astype(np.float32)
    for number, name in enumerate(np.unique(activity)):
        features[activity == name, :GOOD, number] += signal
    for number, name in enumerate(np.unique(source)):
        features[source == name, :, 6 + number] += source_shift
    return MixedWindows(ArrayBlocks(features), activity, motion, source, performer, np.ones(len(rows), bool))


APART = {"film": ("a", "b"), "lab": ("c", "d")}
