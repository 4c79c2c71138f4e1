# SPDX-License-Identifier: GPL-3.0-or-later
"""What carries over from one source of a library to another."""

from typing import NamedTuple

import numpy as np

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map

from .library_repeats import agreement
from .within_sources import RESAMPLES, MixedWindows, SourcedMap, rank_within_sources


def between_sources(found: SourcedMap) -> dict[str, float]:
    """Rho between the maps of an activity in different sources, the mean over their pairs."""
    rho = {}
    for name in found.activities:
        maps = [part.expected_f1[:, part.activities.index(name)] for part in
                (found.parts[source] for source in found.sources_of(name))]  # fmt: skip
        pairs = [(a, b) for number, a in enumerate(maps) for b in maps[number + 1 :]]
        if pairs:
            rho[name] = float(np.mean([agreement(a[None], b[None])[0] for a, b in pairs]))
    return rho


class AcrossSources(NamedTuple):
    """Activities that several sources show, named where their source was never seen, and where it was."""

    unseen: UtilityMap  # one source left out at a time: trained on the others, tested on it
    seen: UtilityMap  # the same windows of the same activities, performers left out instead
    sources: dict[str, dict[str, int]]  # distinct motions of each activity by source


def across_sources(windows: MixedWindows, seed: int = 0) -> AcrossSources:
    """Name the activities that several sources show, one source left out at a time.

    Raises ValueError if fewer than two activities are shown by two sources; the message says why.
    """
    counts = windows.count("source")
    kept = windows.some(np.isin(windows.activity, [name for name, count in counts.items() if count > 1]))
    names = sorted(set(kept.activity.tolist()))
    unseen = utility_map(
        kept.inputs,
        CrossValidation(kept.activity, kept.motion, kept.source, kept.is_test, names, seed=seed),
        resamples=RESAMPLES,
        halvings=0,
    )
    seen = rank_within_sources(kept.as_one_source(), seed=seed, halvings=0)
    return AcrossSources(
        unseen, next(iter(seen.parts.values())), {name: _motions(kept, name) for name in names}
    )


def _motions(windows: MixedWindows, activity: str) -> dict[str, int]:
    """Distinct motions of an activity by source."""
    here = windows.activity == activity
    return {
        source: len(set(windows.motion[here & (windows.source == source)]))
        for source in np.unique(windows.source[here]).tolist()
    }
