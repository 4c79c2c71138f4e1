# SPDX-License-Identifier: GPL-3.0-or-later
"""How far classifiers agree on where to wear a sensor: Spearman's rho over places, overall and by activity.

    python -m benchmarks.classifier_agreement RESULTS --classifier multi3net [--every 1] [--work FOLDER]

RESULTS is the folder of a finished `w2w run`; every k-th of its places is ranked once more with another
classifier, by the same folds, and compared with what the run itself found there. FOLDER keeps what multi3net
has finished. Intervals (95 %) come from a bootstrap over clips, the same resamples for both classifiers; an
activity with few clips has a wide one. "-": one of them scores all places the same, mostly 0.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from w2w.core.ranking.agreement import spearman_rows
from w2w.core.ranking.classifiers.multi3net.classifier import Multi3Net
from w2w.core.ranking.f1 import clip_resamples, count_by_clip, f1_scores
from w2w.core.ranking.utility import CLASSIFIERS, UtilityMap, utility_map
from w2w.core.results_folder import StudyResults

RESAMPLES = 300


class Rho(NamedTuple):
    """Spearman's rho and its interval."""

    rho: float
    low: float
    high: float

    def __str__(self) -> str:
        if np.isnan(self.rho):
            return "   -"
        return f"{self.rho:5.2f}  ({self.low:.2f} to {self.high:.2f})"


class SomePlaces:
    """Some places of another source, as `PatchBlocks`."""

    def __init__(self, source: object, places: Sequence[int]) -> None:
        self._source, self._places = source, list(places)

    @property
    def shape(self) -> tuple[int, ...]:
        """(W, places, ...)."""
        return (self._source.shape[0], len(self._places), *self._source.shape[2:])

    def patches(self, first: int, last: int) -> np.ndarray:
        """All windows of some of them."""
        wanted = self._places[first:last]
        if wanted == list(range(wanted[0], wanted[-1] + 1)):
            return self._source.patches(wanted[0], wanted[-1] + 1)
        return np.concatenate([self._source.patches(place, place + 1) for place in wanted], axis=1)


def rank_again(study: StudyResults, classifier: Any, places: Sequence[int], work: Path | None) -> UtilityMap:
    """The map of some places of a finished study by another classifier, its name or itself."""
    if work is not None and isinstance(classifier, Multi3Net):
        classifier = replace(classifier, checkpoints=work / f"{classifier.width}")
    parameters, windows = study.parameters, [len(clip.is_test) for clip in study.windows]
    return utility_map(
        SomePlaces(study.inputs(classifier), places),
        np.repeat([clip.activity for clip in study.clips], windows),
        np.repeat([clip.motion_key for clip in study.clips], windows),
        np.repeat([clip.subject for clip in study.clips], windows) if parameters["by_subject"] else None,
        np.concatenate([clip.is_test for clip in study.windows]),
        sorted({clip.activity for clip in study.clips}),
        classifier=classifier,
        folds=parameters["folds"],
        seed=parameters["seed"],
        resamples=RESAMPLES,
        work=work,
    )


def compare(
    first: UtilityMap, second: UtilityMap, places: Sequence[int], seed: int = 0
) -> dict[str, tuple[Rho, float, float]]:
    """Agreement and both mean F1, overall ("mean") and by activity; `second` has some places of `first`."""
    if first.activities != second.activities or not np.array_equal(first.clip, second.clip):
        raise ValueError("the two maps are not of the same clips and folds")
    n_activities = len(first.activities)
    counts = [
        count_by_clip(first.truth, named, first.clip, n_activities)
        for named in (first.predictions[:, list(places)], second.predictions)
    ]
    weights = clip_resamples(counts[0].activity, RESAMPLES, np.random.default_rng(seed))
    whole = np.ones((1, weights.shape[1]), dtype=weights.dtype)
    points = [np.nan_to_num(f1_scores(count, whole)[0]) for count in counts]
    samples = [np.nan_to_num(f1_scores(count, weights)) for count in counts]
    result = {}
    for column, name in enumerate(("mean", *first.activities)):
        scores = [
            part.mean(axis=-1) if column == 0 else part[..., column - 1] for part in (*points, *samples)
        ]
        spread = spearman_rows(*scores[2:])
        low, high = np.nanquantile(spread, [0.025, 0.975]) if np.isfinite(spread).any() else (np.nan, np.nan)
        rho = Rho(float(spearman_rows(*scores[:2])), float(low), float(high))
        result[name] = (rho, float(scores[0].mean()), float(scores[1].mean()))
    return result


def main() -> None:
    """Rank again and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--classifier", choices=sorted(CLASSIFIERS), required=True)
    parser.add_argument("--every", type=int, default=1, help="of so many places one")
    parser.add_argument("--work", type=Path)
    options = parser.parse_args()
    study = StudyResults.load(options.results)
    places = range(0, len(study.utility.mean), options.every)
    started = time.process_time()
    again = rank_again(study, options.classifier, places, options.work)
    spent = time.process_time() - started
    print(
        f"{study.utility.classifier} and {again.classifier}: {len(places)} places, {len(study.clips)} clips"
    )
    print(f"{again.classifier} took {spent:.0f} processor seconds")
    print(f"{'':24} Spearman's rho           mean F1 over places")
    for name, (rho, first, second) in compare(study.utility, again, places).items():
        print(f"{name:24} {rho!s:24} {first:.3f} {second:.3f}")


if __name__ == "__main__":
    main()
