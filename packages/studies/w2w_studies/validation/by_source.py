# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores from several comparisons of one source each, in which no source can be recognised."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .site_scores import SiteScores
from .sites import SiteValidation, compare_scores


def merged(parts: Sequence[SiteScores], activities: Sequence[str]) -> SiteScores:
    """Scores of activities, each the mean over the parts that tested it.

    `parts`: of the same sites, with as many resamples and halvings.
    Raises ValueError if no part tested one of them.
    """
    holds = {name: [part for part in parts if name in part.activities] for name in activities}
    if missing := [name for name, having in holds.items() if not having]:
        raise ValueError(f"no part tested {', '.join(missing)}")

    def of(kind: str) -> np.ndarray:
        columns = [
            np.mean([getattr(part, kind)[..., part.activities.index(name)] for part in having], axis=0)
            for name, having in holds.items()
        ]
        return np.stack(columns, axis=-1)

    return replace(
        parts[0],
        activities=tuple(activities),
        f1=of("f1"),
        samples=of("samples"),
        halves=of("halves"),
        n_clips=sum(part.n_clips for part in parts),
        n_windows=sum(part.n_windows for part in parts),
        protocol=f"{len(parts)} comparisons, {parts[0].protocol}",
    )


def replaced_sides(
    whole: SiteValidation, parts: Sequence[SiteValidation], seed: int = 0
) -> dict[str, SiteValidation]:
    """The comparison again with one side at a time, and both, scored source by source.

    Where replacing the simulated side alone brings the rankings together, it was the sources that the
    simulated sensors distinguished.
    """
    activities = whole.real.activities
    real = merged([part.real for part in parts], activities)
    simulated = merged([part.simulated for part in parts], activities)
    sides = {
        "all sources at once, as in the test": (whole.real, whole.simulated),
        "simulated sensors source by source": (whole.real, simulated),
        "worn sensors so, too": (real, simulated),
        "worn sensors alone so": (real, whole.simulated),
    }
    return {name: compare_scores(*of, whole.sites, seed) for name, of in sides.items()}
