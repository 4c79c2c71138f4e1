# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the advice hold for others? Disjoint halves of a library choose, and each other's scores judge.

    python -m benchmarks.repeatability SCRATCH [--only NAME ...] [--halvings 4] [--workers 2]
        [--sets 4] [--patches 512] [--classifier ridge] [--features summary] [--no-shuffled] [--bound]

Libraries, made or unpacked in SCRATCH and run there once: the demo's with 12 and 24 clips an activity,
HDM05 (performers choose and other performers judge), Bandai-Namco (styles likewise), and the mixed library
of real FBX and BVH clips, of activities with four motions or more. Printed for each, over all halvings and
both ways: the promise of the chosen patch and what it delivers on the other half,
the raw F1 of the best patch as a naive user would read it, the gain over an average patch, Spearman's
rho of the two halves' expected maps (mean, and by activity), the share of patches whose interval holds
the other half's value, how many patches are said to be as good as the best, and the reliability that a
half says of its map with the correlation that the other half's map then has with it. For sets of 2 to
`--sets` sensors (0 for none): what a set chosen by one half was promised to give, what it delivers on the
other, and its gain there over sets drawn at random; likewise for sets that the paper's proxy chose, with
the proxy's own mean-max F1. Then the same with labels shuffled between clips, where there is nothing to find.
With `--bound` also what a choice by *all* clips would give on each half, which is part of them: a rule that
sees one half alone cannot be expected to do better.
Sets are of the ridge alone: other classifiers need `--sets 0`.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import json
import subprocess
import sys
import tarfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from w2w.core.clip_ranking import WindowLabels, rank_windows, set_tests
from w2w.core.patches.skin import SkinDistances
from w2w.core.ranking.classifiers.multi3net.classifier import Multi3Net
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.feature_kinds import FEATURES, SUMMARY, features_of
from w2w.core.ranking.inputs import ArrayBlocks, PatchBlocks, SomePatches, SomeWindows
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import CLASSIFIERS, UtilityMap
from w2w.core.results_folder import StudyResults
from w2w.core.selection.joint import chosen_by_halves, grow
from w2w.core.selection.promise import promise, random_sets
from w2w.core.selection.proxy_promise import greedy_by_half
from w2w.core.selection.set_tests import SetTests
from w2w.core.selection.subsets import greedy_order
from w2w.core.selection.terms import Terms
from w2w.core.study import StudyConfig

DATA = Path(__file__).parents[2] / "shared" / "data" / "library"
FEWEST_MOTIONS = 4
"""Motions of an activity of which each half has two, to train on one and test on the other."""
NOT_ACTIVITIES = ("negative", "static_pose", "unknown")


@dataclass(frozen=True, eq=False)
class Library:
    """A library that was run: its windows and where its patches lie."""

    inputs: PatchBlocks
    labels: WindowLabels
    files: np.ndarray
    config: StudyConfig
    pooling: Pooling

    @classmethod
    def open(
        cls, out: Path, n_patches: int, classifier: str = Ridge.name, features: str = SUMMARY
    ) -> Library:
        """Read what a run left, of its first patches, which lie as far apart as may be."""
        study = StudyResults.load(out)
        config = replace(study.config(), classifier=classifier, features=features)
        used = json.loads((out / "summary.json").read_text())["used"]
        files = np.repeat([entry["file"] for entry in used], [len(found.is_test) for found in study.windows])
        skin = SkinDistances.of(study.body(), study.patches)
        some = (slice(n_patches),) * 2
        pooling = Pooling.over(SkinDistances(skin.between[some], skin.to_mirror_image[some]))
        as_run = features == study.config().features
        inputs = SomePatches(study.inputs(classifier if as_run else Multi3Net.name), 0, len(pooling.kernel))
        inputs = inputs if as_run else described(inputs, config)
        return cls(inputs, study.labels(), files, config, pooling).halvable()

    def halvable(self) -> Library:
        """The windows of activities that both halves can test."""
        names = np.unique(self.labels.activity)
        motions = [len(np.unique(self.labels.motion[self.labels.activity == name])) for name in names]
        rows = np.flatnonzero(np.isin(self.labels.activity, names[np.array(motions) >= FEWEST_MOTIONS]))
        labels = self.part(rows, self.labels.activity)
        return replace(self, inputs=SomeWindows(self.inputs, rows), labels=labels, files=self.files[rows])

    def part(self, rows: np.ndarray, activity: np.ndarray) -> WindowLabels:
        """Labels of some windows."""
        return replace(self.labels.some(rows), activity=activity[rows])

    def rank(self, rows: np.ndarray, by_subject: bool, activity: np.ndarray) -> UtilityMap:
        """Rank on some windows."""
        config = replace(self.config, by_subject=by_subject)
        inputs = SomeWindows(self.inputs, rows)
        return rank_windows(inputs, self.part(rows, activity), config, pooling=self.pooling)

    def sets(self, rows: np.ndarray, by_subject: bool, activity: np.ndarray, utility: UtilityMap) -> SetTests:
        """What sets are chosen and judged by, on some windows that were ranked."""
        config, inputs = replace(self.config, by_subject=by_subject), SomeWindows(self.inputs, rows)
        return set_tests(inputs, self.part(rows, activity), config, self.pooling, utility=utility)


def described(windows: PatchBlocks, config: StudyConfig) -> ArrayBlocks:
    """Other features of windows than the run's, some patches at a time."""
    _, n_patches, samples, _ = windows.shape
    rate = samples / config.windows.length_s
    parts = [
        features_of(windows.patches(*span), rate, config.features, config.seed)
        for span in ((first, min(first + 16, n_patches)) for first in range(0, n_patches, 16))
    ]
    return ArrayBlocks(np.concatenate(parts, axis=1))


def halves_of_clips(library: Library, number: int) -> np.ndarray:
    """Half of each activity's motions."""
    rng = np.random.default_rng(number)
    half = np.zeros(len(library.files), dtype=bool)
    for name in np.unique(library.labels.activity):
        rows = library.labels.activity == name
        motions = np.unique(library.labels.motion[rows])
        rng.shuffle(motions)
        half |= rows & np.isin(library.labels.motion, motions[: len(motions) // 2])
    return half


def styles(library: Library) -> np.ndarray:
    """The style of each window that Bandai-Namco's file names tell, for who it is."""
    return np.array([Path(file).stem.split("_")[-2] for file in library.files])


def halves_of_styles(library: Library, number: int) -> np.ndarray:
    """Half of the styles."""
    names = np.unique(library.labels.subject)
    np.random.default_rng(number).shuffle(names)
    return np.isin(library.labels.subject, names[: len(names) // 2])


def halves_of_performers(library: Library, number: int) -> np.ndarray:
    """Two of five performers against the other three."""
    pairs = list(itertools.combinations(np.unique(library.labels.subject), 2))
    np.random.default_rng(0).shuffle(pairs)
    return np.isin(library.labels.subject, pairs[number % len(pairs)])


@dataclass(frozen=True)
class Case:
    """A library, how it is made, how it is halved, and who its subjects are where no csv says so."""

    make: Callable[[Path], list[str]]
    halve: Callable[[Library, int], np.ndarray]
    by_subject: bool = False
    subjects: Callable[[Library], np.ndarray] | None = None


def demo(clips: int) -> Callable[[Path], list[str]]:
    def make(folder: Path) -> list[str]:
        w2w("demo-library", str(folder), "--clips", str(clips))
        return []

    return make


def unpack(name: str, *options: str) -> Callable[[Path], list[str]]:
    def make(folder: Path) -> list[str]:
        with tarfile.open(DATA / f"{name}.tar.xz") as archive:
            archive.extractall(folder, filter="data")
        return [option.format(folder=folder) for option in options]

    return make


def mixed(folder: Path) -> list[str]:
    """Real FBX and BVH clips of activities."""
    folder.symlink_to(DATA.parent, target_is_directory=True)
    with (DATA.parent / "motions.csv").open(newline="", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["activity"] not in NOT_ACTIVITIES]
    labels = folder.with_suffix(".csv")
    with labels.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, ("file", "activity", "motion_key"), extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    return ["--labels", str(labels)]


CASES = {
    "demo12": Case(demo(12), halves_of_clips),
    "demo24": Case(demo(24), halves_of_clips),
    "hdm05": Case(unpack("hdm05", "--labels", "{folder}/labels.csv"), halves_of_performers, by_subject=True),
    "bandai": Case(unpack("bandai_namco"), halves_of_styles, by_subject=True, subjects=styles),
    "mixed": Case(mixed, halves_of_clips),
}


def w2w(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "headless", *arguments], check=True, stdout=subprocess.DEVNULL)


def prepared(name: str, scratch: Path, workers: int, *chosen: int | str) -> Library:
    """A case's library, run once; the patches, classifier and features chosen."""
    out = scratch / f"{name}_out"
    if not (out / "summary.json").exists():
        clips = scratch / name
        options = CASES[name].make(clips)
        w2w(
            "run",
            str(clips),
            "--out",
            str(out),
            "--no-pictures",
            "--no-report",
            "--workers",
            str(workers),
            *options,
        )
    library = Library.open(out, *chosen)
    subjects = CASES[name].subjects
    if subjects is None:
        return library
    return replace(library, labels=replace(library.labels, subject=subjects(library)))


def judged(
    library: Library, case: Case, halvings: int, shuffle: bool, largest: int, bound: bool
) -> Iterator[dict[str, float]]:
    """What each half promised and the other delivered."""
    activity = library.labels.activity
    every = (np.arange(len(activity)), case.by_subject, activity)
    whole = library.rank(*every) if bound else None
    of_all = chosen(whole, library.sets(*every, whole), largest) if whole is not None and largest > 1 else []
    for number in range(halvings):
        if shuffle:
            motions, first = np.unique(library.labels.motion, return_index=True)
            mixed = np.random.default_rng(number).permutation(library.labels.activity[first])
            activity = mixed[np.searchsorted(motions, library.labels.motion)]
        half = case.halve(library, number)
        sides = [(np.flatnonzero(rows), case.by_subject, activity) for rows in (half, ~half)]
        maps = [library.rank(*side) for side in sides]
        ranked = zip(sides, maps, strict=True)
        tests = [library.sets(*side, utility) for side, utility in ranked] if largest > 1 else []
        for here, there in ((0, 1), (1, 0)):
            found = compare(maps[here], maps[there])
            if whole is not None:
                by_all = compare(whole, maps[there])
                found |= {f"bound {name}": by_all[name] for name in ("gain", "rho", "rho by activity")}
            if tests:
                found |= compare_sets(maps[here], tests[here], tests[there], largest)
            if len(of_all) > 1:
                delivered = macro_f1(tests[there], of_all) - chance(tests[there], free(maps[there], largest))
                found |= {f"bound gain of {n}": float(delivered[n - 1]) for n in range(2, len(of_all) + 1)}
            yield found


def compare(here: UtilityMap, there: UtilityMap) -> dict[str, float]:
    best = int(here.expected_mean.argmax())
    shared = [name for name in here.activities if name in there.activities]
    columns = [(here.activities.index(name), there.activities.index(name)) for name in shared]
    rho = [rank_correlation(here.expected_f1[:, a], there.expected_f1[:, b]) for a, b in columns]
    return {
        "promise": float(here.expected_mean[best]),
        "delivery": float(there.mean[best]),
        "naive": float(here.mean.max()),
        "gain": float(there.mean[best] - there.mean.mean()),
        "rho": rank_correlation(here.expected_mean, there.expected_mean),
        "rho by activity": float(np.nanmean(rho)),
        "raw rho": rank_correlation(here.mean, there.mean),
        "holds": held(here, there.expected_mean),
        "holds raw": held(here, there.mean),
        "as good": float(here.as_good.mean()),
        "ranks": float(here.can_rank),
        "reliability": here.reliability,
        "correlation": correlation(here.expected_mean, there.expected_mean),
    }


def compare_sets(utility: UtilityMap, here: SetTests, there: SetTests, largest: int) -> dict[str, float]:
    terms = free(utility, largest)
    expected = (utility.expected_mean, utility.expected_low, utility.expected_high)
    by_luck = chance(there, terms)
    ways = {
        "of": (chosen(utility, here, largest), chosen_by_halves),
        "of the proxy's": (greedy_order(terms), greedy_by_half),
    }
    found = {}
    for way, (order, choose) in ways.items():
        made = promise(here, terms, order, choose, tuple(float(one[order[0]]) for one in expected))
        delivered = macro_f1(there, order)
        of_size = {
            "promise": made.mean,
            "delivery": delivered,
            "gain": delivered - by_luck[: len(order)],
            "naive": np.nanmean(made.raw, axis=1),
        }
        if way != "of":
            of_size["mean-max"] = np.maximum.accumulate(terms.f1[list(order)], axis=0).mean(axis=1)
        for number in range(2, largest + 1):
            for what, values in of_size.items():
                found[f"{what} {way} {number}"] = float(values[min(number, len(values)) - 1])
    return found


def free(utility: UtilityMap, largest: int) -> Terms:
    """Any patches, so many at most."""
    return Terms.checked(utility.f1, largest, None, (), None)


def chosen(utility: UtilityMap, tests: SetTests, largest: int) -> Sequence[int]:
    """The patches that a run would choose, in their order."""
    return grow(tests.whole, free(utility, largest), largest, utility.expected_mean).order


def macro_f1(tests: SetTests, order: Sequence[int]) -> np.ndarray:
    """Of the first patch, the first two, and so on, shape (K,)."""
    return np.nanmean(tests.whole.f1_of_first(order), axis=1)


def chance(tests: SetTests, terms: Terms) -> np.ndarray:
    """Macro F1 of sets drawn at random, by size, shape (K,)."""
    drawn = random_sets(terms, terms.max_size, seed=99)
    return np.nanmean([tests.whole.f1_of_first(one) for one in drawn], axis=(0, 2))


def rank_correlation(one: np.ndarray, other: np.ndarray) -> float:
    return float(spearmanr(one, other)[0]) if np.ptp(one) > 0 and np.ptp(other) > 0 else np.nan


def correlation(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.corrcoef(one, other)[0, 1]) if np.ptp(one) > 0 and np.ptp(other) > 0 else 0.0


def held(here: UtilityMap, other: np.ndarray) -> float:
    return float(((here.expected_low <= other) & (other <= here.expected_high)).mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--only", nargs="*", choices=CASES, default=list(CASES))
    parser.add_argument("--halvings", type=int, default=4)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--sets", type=int, default=4)
    parser.add_argument("--patches", type=int, default=512)
    parser.add_argument("--classifier", choices=CLASSIFIERS, default=Ridge.name)
    parser.add_argument("--features", choices=FEATURES, default=SUMMARY)
    parser.add_argument("--bound", action="store_true")
    parser.add_argument("--shuffled", action=argparse.BooleanOptionalAction, default=True)
    given = parser.parse_args()
    if given.sets > 1 and given.classifier != Ridge.name:
        parser.error("sets are of the ridge alone: --sets 0")
    given.scratch.mkdir(parents=True, exist_ok=True)
    for name in given.only:
        settings = (given.patches, given.classifier, given.features)
        library = prepared(name, given.scratch, given.workers, *settings)
        for shuffle in (False, True) if given.shuffled else (False,):
            found = list(judged(library, CASES[name], given.halvings, shuffle, given.sets, given.bound))
            mean = {key: np.nanmean([row[key] for row in found]) for key in found[0]}
            words = "  ".join(f"{key} {value:.3f}" for key, value in mean.items())
            difference = mean["promise"] - mean["delivery"]
            print(f"{name}{', shuffled' if shuffle else ''}: {words}  off {difference:+.3f}", flush=True)


if __name__ == "__main__":
    main()
