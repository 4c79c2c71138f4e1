# SPDX-License-Identifier: GPL-3.0-or-later
"""What is generally good: how regions of a body do in families of libraries, by what runs left of them."""

import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.findings.summary import versions
from w2w.core.patches.body_parts import side_of
from w2w.core.study.results import StudyResults

DIGITS = 4

Prior = dict[str, float]
"""F1 above that of an average patch, by region without its side."""


def of_library(study: StudyResults) -> Prior:
    """How the regions of one library do: raw F1 less its mean over patches, the sides together."""
    above = study.utility.mean - study.utility.mean.mean()
    regions = np.array([side_of(region)[1] for region in study.patches.regions])
    return {region: float(above[regions == region].mean()) for region in sorted(set(regions.tolist()))}


def mean_of(priors: Sequence[Mapping[str, float]]) -> Prior:
    """The mean of several, of each region over those that have it."""
    regions = sorted({region for prior in priors for region in prior})
    return {region: float(np.mean([p[region] for p in priors if region in p])) for region in regions}


def finished_runs(family: Path) -> dict[str, StudyResults]:
    """The runs in a family's folder, by name; ValueError if there are none, or one is not finished."""
    folders = sorted(path for path in family.iterdir() if (path / "summary.json").exists())
    if not folders:
        raise ValueError(f"{family} holds no results folder: run each library into a folder of its own in it")
    return {folder.name: StudyResults.load(folder) for folder in folders}


def general(families: Sequence[Path]) -> dict[str, Any]:
    """The mean over families of the means over their libraries, with where it is from."""
    runs = {family.resolve().name: finished_runs(family) for family in families}
    found = [mean_of([of_library(study) for study in of_family.values()]) for of_family in runs.values()]
    return {
        "about": "F1 of one sensor above that of an average patch, by region without its side: raw F1 less "
        "its mean, averaged over the libraries of a family and then over families. Figures only.",
        "command": f"w2w study prior {' '.join(map(os.fspath, runs))}",
        "version": versions()["w2w"],
        "date": datetime.now(UTC).date().isoformat(),
        "families": {
            name: {library: _about(study) for library, study in of_family.items()}
            for name, of_family in runs.items()
        },
        "regions": {region: round(above, DIGITS) for region, above in mean_of(found).items()},
    }


def _about(study: StudyResults) -> dict[str, Any]:
    return {
        "clips": sum(clip.activity in study.utility.activities for clip in study.clips),
        "activities": list(study.utility.activities),
        "patches": len(study.utility.mean),
    }
