# SPDX-License-Identifier: GPL-3.0-or-later
"""Is it the activity that is recognised, or where its clips are from?

Where each source shows other activities, a classifier may learn their recording systems instead. Within one
activity that several sources show, whoever tells the sources apart can do nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..ranking.utility import utility_map
from .site_windows import SiteWindows


class SourceTest(NamedTuple):
    """How well the source of one activity's clips is recognised, whoever moves left out.

    Attributes
    ----------
    activity : str
    sources : tuple of str
    f1 : ndarray, shape (S,)
        Macro F1 by site; one over the number of sources is chance.
    """

    activity: str
    sources: tuple[str, ...]
    f1: np.ndarray


def source_tests(
    windows: SiteWindows, source_of: Mapping[str, str], site_of: np.ndarray, seed: int = 0
) -> list[SourceTest]:
    """Classify the source within each activity that two sources show with two movers each.

    Parameters
    ----------
    windows : SiteWindows
        Of P sensors; subjects say who moves.
    source_of : mapping of str to str
        Source of each clip.
    site_of : ndarray of int, shape (P,)
    seed : int
    """
    source = np.array([source_of[clip] for clip in windows.clip.tolist()])
    found = []
    for activity in np.unique(windows.activity):
        rows = windows.activity == activity
        movers = {
            name: len(set(windows.subject[rows & (source == name)])) for name in np.unique(source[rows])
        }
        sources = [name for name, count in movers.items() if count > 1]
        if len(sources) < 2:
            continue
        kept = rows & np.isin(source, sources)
        told = utility_map(
            windows.features[kept], source[kept], windows.subject[kept], None, windows.is_test[kept],
            sources, seed=seed, halvings=0,
        )  # fmt: skip
        by_site = np.array([told.mean[site_of == site].mean() for site in range(int(site_of.max()) + 1)])
        found.append(SourceTest(str(activity), told.activities, by_site))
    return found
