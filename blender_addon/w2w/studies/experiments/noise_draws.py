# SPDX-License-Identifier: GPL-3.0-or-later
r"""Would a map repeat better if every clip were recorded with several draws of noise and mounting?

    python -m w2w.studies.experiments.noise_draws RESULTS [--draws 4] [--every 8] [--sensor watch] \
        [--halvings 3]

The motions of a run are recorded anew, each draw with sensor errors and mountings of its own, at every so
many of its patches. Disjoint halves of the performers (of the clips, where nobody is named) rank each draw,
and the mean map of all draws. Printed is Spearman's rho, expected and raw: between two draws of the same
clips, between the halves by one draw, and between the halves by the mean of all draws.
"""

from __future__ import annotations

import argparse
import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np

from w2w.core.clip_ranking import WindowLabels
from w2w.core.imu.virtual import at_patches
from w2w.core.ranking.agreement import spearman_rows
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map
from w2w.core.results_folder import StudyResults
from w2w.core.study import StudyConfig, describe, record
from w2w.core.windows.inputs import ArrayBlocks, SomeWindows
from w2w.headless.options import sensor_settings


def main() -> None:
    """Record, rank and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--every", type=int, default=8)
    parser.add_argument("--sensor", default="watch")
    parser.add_argument("--halvings", type=int, default=3)
    asked = parser.parse_args()
    study = StudyResults.load(asked.results)
    config = replace(study.config(), **sensor_settings(asked.sensor))
    chosen = np.arange(0, len(study.patches), asked.every)
    pooling = Pooling.on(study.body(), at_patches(study.patches, chosen.tolist()))
    draws = [recorded(study, chosen, replace(config, seed=number)) for number in range(asked.draws)]
    labels = study.labels()
    found: dict[str, list[float]] = {}
    for number in range(asked.halvings):
        side = halved(labels, number)
        halves = [np.flatnonzero(rows) for rows in (side, ~side)]
        maps = np.array([[ranked(one, labels, rows, config, pooling) for one in draws] for rows in halves])
        for name, values in agreements(maps).items():
            found.setdefault(name, []).extend(values)
    print(f"{len(study.clips)} clips, {len(chosen)} patches, {asked.draws} draws of {config.sensor}")
    for name, values in found.items():
        print(f"{name:40s} {np.mean(values):.3f}")


def recorded(study: StudyResults, chosen: np.ndarray, config: StudyConfig) -> ArrayBlocks:
    """Features of all windows by one draw."""
    body, patches = study.body(), at_patches(study.patches, chosen)
    motions = (study.motion(clip.name) for clip in study.clips)
    return ArrayBlocks(
        np.concatenate([describe(record(body, patches, one, config), config)[0] for one in motions])
    )


def halved(labels: WindowLabels, number: int) -> np.ndarray:
    """Half of the performers, or of each activity's clips, shape (W,)."""
    rng = np.random.default_rng(number)
    if (labels.subject != "").all():
        return np.isin(labels.subject, dealt(np.unique(labels.subject), rng))
    of_activity = (np.unique(labels.motion[labels.activity == name]) for name in np.unique(labels.activity))
    return np.isin(labels.motion, np.concatenate([dealt(motions, rng) for motions in of_activity]))


def dealt(names: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Half of the names."""
    return rng.permutation(names)[: len(names) // 2]


def ranked(
    draw: ArrayBlocks, labels: WindowLabels, rows: np.ndarray, config: StudyConfig, pooling: Pooling
) -> np.ndarray:
    """Expected and raw macro F1 of the patches by some windows, shape (2, N)."""
    protocol = labels.some(rows).protocol(config)
    utility = utility_map(SomeWindows(draw, rows), protocol, config.classifier, pooling=pooling)
    return np.array([utility.expected_mean, utility.mean])


def agreements(maps: np.ndarray) -> dict[str, list[float]]:
    """Rhos of maps, shape (halves, draws, 2, N)."""
    found = {}
    for kind, of_kind in zip(("expected", "raw"), maps.transpose(2, 0, 1, 3), strict=True):
        pairs = [pair for half in of_kind for pair in itertools.combinations(half, 2)]
        found[f"{kind}, two draws of the same clips"] = [spearman_rows(*pair) for pair in pairs]
        found[f"{kind}, halves by one draw"] = [spearman_rows(*pair) for pair in zip(*of_kind, strict=True)]
        found[f"{kind}, halves by the mean of all draws"] = [spearman_rows(*of_kind.mean(axis=1))]
    return found


if __name__ == "__main__":
    main()
