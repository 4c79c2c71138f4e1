# SPDX-License-Identifier: GPL-3.0-or-later
"""How far classifiers agree on where to wear a sensor: Spearman's rho over places, overall and by activity.

    python -m benchmarks.classifier_agreement RESULTS --classifier multi3net [--every 1] [--least 1]
                                            [--folds 0,1] [--work FOLDER] [--other-seed 1]

RESULTS is the folder of a finished `w2w run`; every k-th of its places is ranked once more with another
classifier, by the same folds, and compared with what the run itself found there. With `--least 20` activities
of fewer than 20 clips stay out, and both classifiers rank anew. With `--folds 0,1` the clips of two of the
folds are tested, where all five would take too long. FOLDER keeps what multi3net has finished. With
`--other-seed 1` the other classifier ranks once more with that seed: no map can be expected to agree with it
better than it does with itself.
Intervals (95 %) come from a bootstrap over clips, the same resamples for both classifiers; an activity with
few clips has a wide one. "-": one of them scores all places the same, mostly 0.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from w2w.core.ranking.agreement import spearman_rows
from w2w.core.ranking.f1 import ClipUnits, clip_resamples, f1_scores
from w2w.core.ranking.halves import Protocol
from w2w.core.ranking.utility import CLASSIFIERS, UtilityMap, maker, utility_map
from w2w.core.study.results import StudyResults
from w2w.core.windows.inputs import BLOCK_BYTES, ITEM_BYTES, ArrayBlocks, PatchBlocks, SomeWindows
from w2w.studies.classifiers.multi3net.classifier import Multi3Net

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


@dataclass(eq=False)
class SomeFolds:
    """A network that is tested on some of the folds alone; of the others it names nothing.

    Attributes
    ----------
    tested : ndarray of bool
        Which of the test windows are in those folds.
    """

    model: Multi3Net
    folds: tuple[int, ...]
    tested: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    name: str = "multi3net"
    inputs: str = "windows"

    def predict_folds(
        self, windows: object, labels: np.ndarray, fold: np.ndarray, is_test: np.ndarray, progress: object
    ) -> np.ndarray:
        """As `Multi3Net.predict_folds`; what stands for windows of the other folds means nothing."""
        some = is_test & np.isin(fold, np.unique(fold[is_test])[list(self.folds)])
        self.tested = some[is_test]
        named = np.zeros((len(self.tested), windows.shape[1]), dtype=np.int16)
        named[self.tested] = self.model.predict_folds(windows, labels, fold, some, progress)
        return named


def rank_again(
    study: StudyResults, classifier: Any, places: Sequence[int], work: Path | None, least: int = 1
) -> UtilityMap:
    """The map of some places of a finished study by another classifier, its name or itself.

    Activities of fewer clips than `least` stay out.
    """
    if work is not None and isinstance(classifier, Multi3Net):
        classifier = replace(classifier, checkpoints=work / f"{classifier.width}")
    parameters, labels = study.parameters, study.labels()
    many = [name for name, n in Counter(clip.activity for clip in study.clips).items() if n >= least]
    rows = np.flatnonzero(np.isin(labels.activity, many))
    of = labels.some(rows)
    return utility_map(
        in_memory(SomePlaces(SomeWindows(study.inputs(classifier), rows), places)),
        Protocol(
            of.activity,
            of.motion,
            of.subject if parameters["by_subject"] else None,
            of.is_test,
            sorted(many),
            folds=parameters["folds"],
            seed=parameters["seed"],
        ),
        classifier,
        resamples=RESAMPLES,
        work=work,
    )


def in_memory(source: SomePlaces) -> PatchBlocks:
    """All of a source at once, where that is little."""
    little = math.prod(source.shape) * ITEM_BYTES <= BLOCK_BYTES
    return ArrayBlocks(source.patches(0, source.shape[1])) if little else source


def compare(
    first: UtilityMap,
    second: UtilityMap,
    places: Sequence[int],
    seed: int = 0,
    tested: np.ndarray | slice = slice(None),
) -> dict[str, tuple[Rho, float, float]]:
    """Agreement and both mean F1, overall ("mean") and by activity; `second` has these places of `first`.

    Only some of the test windows may have been `tested`.
    """
    if first.activities != second.activities or not np.array_equal(first.clip, second.clip):
        raise ValueError("the two maps are not of the same clips and folds")
    n_activities = len(first.activities)
    counts = [
        ClipUnits(first.truth[tested], first.clip[tested], n_activities).count(named[tested])
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


def some_folds(options: argparse.Namespace, seed: int) -> SomeFolds:
    """The network that is tested on the folds asked for."""
    work = None if options.work is None else options.work / Multi3Net.name
    folds = tuple(int(number) for number in options.folds.split(","))
    return SomeFolds(Multi3Net(seed=seed, checkpoints=work), folds)


def main() -> None:
    """Rank again and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--classifier", choices=sorted(CLASSIFIERS), required=True)
    parser.add_argument("--every", type=int, default=1, help="of so many places one")
    parser.add_argument("--least", type=int, default=1, help="clips of an activity")
    parser.add_argument("--folds", help="numbers of those that are tested, from 0; of multi3net alone")
    parser.add_argument("--work", type=Path)
    parser.add_argument("--other-seed", type=int, help="of the other classifier, ranked once more")
    options = parser.parse_args()
    if options.folds is not None and options.other_seed is not None:
        parser.error("--other-seed needs all folds: leave --folds out")
    study = StudyResults.load(options.results)
    places = range(0, len(study.utility.mean), options.every)
    started = time.process_time()
    classifier = (
        options.classifier if options.folds is None else some_folds(options, study.parameters["seed"])
    )
    again = rank_again(study, classifier, places, options.work, options.least)
    spent = time.process_time() - started
    first, compared = study.utility, places
    if options.least > 1:
        first, compared = rank_again(study, first.classifier, places, None, options.least), range(len(places))
    print(f"{first.classifier} and {again.classifier}: {len(places)} places, {len(set(again.clip))} clips")
    print(f"{again.classifier} took {spent:.0f} processor seconds")
    tested = slice(None) if options.folds is None else classifier.tested
    print(f"{len(again.truth[tested])} of {len(again.truth)} test windows")
    print(f"{'':24} Spearman's rho           mean F1 over places")
    for name, (rho, *f1) in compare(first, again, compared, tested=tested).items():
        _print_line(name, rho, f1)
    if options.other_seed is not None:
        other = maker(options.classifier)(seed=options.other_seed)
        once_more = rank_again(study, other, places, None, options.least)
        rho, *f1 = compare(again, once_more, range(len(places)))["mean"]
        _print_line(f"{again.classifier}, both seeds", rho, f1)


def _print_line(name: str, rho: Rho, f1: Sequence[float]) -> None:
    print(f"{name:24} {rho!s:24} {f1[0]:.3f} {f1[1]:.3f}")


if __name__ == "__main__":
    main()
