# SPDX-License-Identifier: GPL-3.0-or-later
"""Is it the activity that is recognised, or where its clips are from?

Where each source shows other activities, a classifier may learn their recording systems instead. Within one
activity that several sources show, whoever tells the sources apart can do nothing else.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.windows.inputs import PatchBlocks, SomeWindows, as_blocks

from .site_windows import SiteWindows


class SourceTest(NamedTuple):
    """How well the source of one activity's clips is recognised, whoever moves left out."""

    activity: str
    sources: tuple[str, ...]
    f1: np.ndarray  # (S,): macro F1 by site; one over the number of sources is chance


def source_tests(
    windows: SiteWindows, source_of: Mapping[str, str], site_of: np.ndarray, seed: int = 0
) -> list[SourceTest]:
    """Classify the source within each activity that two sources show with two movers each.

    `site_of` (P,) of int.
    `windows`: of P sensors; subjects say who moves.
    `source_of`: source of each clip.
    """
    source = np.array([source_of[clip] for clip in windows.clip.tolist()])
    labels = (windows.activity, source, windows.subject, windows.is_test)
    return [
        SourceTest(
            activity,
            told.activities,
            np.array([told.mean[site_of == site].mean() for site in range(int(site_of.max()) + 1)]),
        )
        for activity, told in told_sources(windows.features, *labels, seed).items()
    ]


def told_sources(
    inputs: np.ndarray | PatchBlocks,
    activity: np.ndarray,
    source: np.ndarray,
    mover: np.ndarray,
    is_test: np.ndarray,
    seed: int = 0,
) -> dict[str, UtilityMap]:
    """Name the source within each activity that two sources show with two movers each, at every sensor.

    `activity`, `source`, `mover` (W,) of str, `is_test` (W,) of bool.
    `inputs` (W, P, D): features.
    Returns a map for each activity, whose labels are sources.
    """
    found = {}
    for name in np.unique(activity).tolist():
        rows = activity == name
        movers = {where: len(set(mover[rows & (source == where)])) for where in np.unique(source[rows])}
        sources = [where for where, count in movers.items() if count > 1]
        if len(sources) < 2:
            continue
        kept = np.flatnonzero(rows & np.isin(source, sources))
        found[name] = utility_map(
            SomeWindows(as_blocks(inputs), kept),
            CrossValidation(source[kept], mover[kept], None, is_test[kept], sources, seed=seed),
            halvings=0,
        )
    return found
