# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the advice hold for others? Disjoint halves of a library choose, and each other's raw scores judge.

    python -m benchmarks.repeatability SCRATCH [--only NAME ...] [--halvings 5] [--workers 2]
        [--sets 4] [--patches 512] [--classifier ridge] [--no-shuffled] [--rows FILE]

Libraries, made or unpacked in SCRATCH and run there once: the demo's with 12 and 24 clips an activity, HDM05,
Bandai-Namco and the mixed library of real FBX and BVH clips, of activities with four motions or more. Each is
halved by clip and, where people or styles are known, by subject. Printed for each, over all halvings and both
ways:

promise    what the chosen patch is expected to give
delivery   what it gives on the other half: its raw mean F1 there
gain       how much more that is than an average patch's; by F1: the gain of the patch of the highest raw F1;
           oracle: that of the other half's own best
rho        Spearman's, of the expected map with the other half's raw map; ceiling: the root of the raw maps';
           hindsight: by the width of skin and share of the sides' difference that the other half would pick
chance     stated, of beating an average patch; better: how often it did
holds      share of patches whose interval holds the other half's raw F1
as good    share of patches said to be as good as the best
ranks      how often the clips are said to rank placements

For sets of 2 to `--sets` sensors (0 for none, as with any classifier but the ridge): what a set chosen by one
half was promised to give, what it delivers on the other, and its gain there over sets drawn at random;
likewise for sets that the paper's proxy chose, with the proxy's own mean-max F1. Then the same with labels
shuffled between clips, where there is nothing to find. Last, the chances stated against those found. `--rows`
adds every choice to a file as it is made, a line of JSON each.
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

from w2w.core.imu.virtual import at_patches
from w2w.core.patches.strip_graph import SkinDistances
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import CLASSIFIERS, UtilityMap, utility_map
from w2w.core.selection.answer import product_patches
from w2w.core.selection.constraints import Terms
from w2w.core.selection.joint import ByHalves, GrownSet
from w2w.core.selection.promise import Promises, random_sets
from w2w.core.selection.set_tests import SetTests
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import WindowLabels, set_tests
from w2w.core.study.results import StudyResults
from w2w.core.windows.inputs import PatchBlocks, SomePatches, SomeWindows
from w2w.studies.paper.promised import greedy_by_half
from w2w.studies.paper.subsets import checked_terms, greedy_order

DATA = Path(__file__).parents[2] / "shared" / "data" / "library"
FEWEST_MOTIONS = 4
"""Motions of an activity of which each half has two, to train on one and test on the other."""
CHANCES = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0001)
"""Bounds between which stated chances are compared with found ones."""
DISTINCT = 10
"""Halvings by subject that differ from each other; five subjects have no more."""
WIDTHS = (0.001, 0.03, 0.05, 0.08, 0.1, 0.15, 0.25, 0.4)
SHARES = (0.0, 0.5, 1.0)
NOT_ACTIVITIES = ("negative", "static_pose", "unknown")


@dataclass(frozen=True, eq=False)
class Library:
    """A library that was run: its windows and where its patches lie."""

    inputs: PatchBlocks
    labels: WindowLabels
    files: np.ndarray
    config: StudyConfig
    pooling: Pooling
    poolings: Sequence[Pooling]
    products: np.ndarray  # (N,), bool: patches at which usual products sit

    @classmethod
    def open(cls, out: Path, n_patches: int, classifier: str = Ridge.name) -> Library:
        """Read what a run left, of its first patches, which lie as far apart as may be."""
        study = StudyResults.load(out)
        config = replace(study.config(), classifier=classifier)
        used = json.loads((out / "summary.json").read_text())["used"]
        files = np.repeat([entry["file"] for entry in used], [len(found.is_test) for found in study.windows])
        first = at_patches(study.patches, list(range(len(study.patches)))[:n_patches])
        skin = SkinDistances.of(study.body(), first.vertices)
        pooling, others = Pooling.over(skin), [Pooling.over(skin, width) for width in WIDTHS]
        inputs = SomePatches(study.inputs(classifier), 0, len(pooling.kernel))
        products = np.isin(np.arange(len(first)), list(product_patches(first, study.body())))
        return cls(inputs, study.labels(), files, config, pooling, others, products).halvable()

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
        protocol = self.part(rows, activity).protocol(config)
        return utility_map(inputs, protocol, config.classifier, pooling=self.pooling)

    def sets(self, rows: np.ndarray, by_subject: bool, activity: np.ndarray, utility: UtilityMap) -> SetTests:
        """What sets are chosen and judged by, on some windows that were ranked."""
        config, inputs = replace(self.config, by_subject=by_subject), SomeWindows(self.inputs, rows)
        return set_tests(inputs, self.part(rows, activity), config, self.pooling, utility=utility)


def halves_of_clips(library: Library, rng: np.random.Generator) -> np.ndarray:
    """Half of each activity's motions."""
    half = np.zeros(len(library.files), dtype=bool)
    for name in np.unique(library.labels.activity):
        rows = library.labels.activity == name
        motions = rng.permutation(np.unique(library.labels.motion[rows]))
        half |= rows & np.isin(library.labels.motion, motions[: len(motions) // 2])
    return half


def halves_of_subjects(library: Library, rng: np.random.Generator) -> np.ndarray:
    """Half of the subjects."""
    names = rng.permutation(np.unique(library.labels.subject))
    return np.isin(library.labels.subject, names[: len(names) // 2])


def labelled(library: Library) -> np.ndarray:
    """Who moves, as the library's labels say."""
    return library.labels.subject


def styles(library: Library) -> np.ndarray:
    """The style of each window that Bandai-Namco's file names tell, for who it is."""
    return np.array([Path(file).stem.split("_")[-2] for file in library.files])


@dataclass(frozen=True)
class Case:
    """A library, how it is made, and who its subjects are."""

    make: Callable[[Path], list[str]]
    subjects: Callable[[Library], np.ndarray] | None = None


def demo(clips: int) -> Callable[[Path], list[str]]:
    def make(folder: Path) -> list[str]:
        w2w("demo-library", str(folder), "--clips", str(clips))
        return ["--labels", str(folder / "labels.csv")]

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
    "demo12": Case(demo(12), labelled),
    "demo24": Case(demo(24), labelled),
    "hdm05": Case(unpack("hdm05", "--labels", "{folder}/labels.csv"), labelled),
    "bandai": Case(unpack("bandai_namco"), styles),
    "mixed": Case(mixed),
}


def w2w(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "headless", *arguments], check=True, stdout=subprocess.DEVNULL)


def prepared(name: str, scratch: Path, workers: int, *chosen: int | str) -> Library:
    """A case's library, run once; the patches and classifier chosen."""
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
    library: Library, by_subject: bool, halvings: int, shuffle: bool, largest: int
) -> Iterator[dict[str, float]]:
    """What each half promised and the other delivered."""
    activity = library.labels.activity
    halve = halves_of_subjects if by_subject else halves_of_clips
    made: list[np.ndarray] = []
    for number in range(halvings):
        rng = np.random.default_rng(number)
        if shuffle:
            motions, first = np.unique(library.labels.motion, return_index=True)
            mixed = rng.permutation(library.labels.activity[first])
            activity = mixed[np.searchsorted(motions, library.labels.motion)]
        half = halve(library, rng)
        while by_subject and len(made) < DISTINCT and any((half == one).mean() in (0, 1) for one in made):
            half = halve(library, rng)
        made.append(half)
        sides = [(np.flatnonzero(rows), by_subject, activity) for rows in (half, ~half)]
        maps = [library.rank(*side) for side in sides]
        ranked = zip(sides, maps, strict=True)
        tests = [library.sets(*side, utility) for side, utility in ranked] if largest > 1 else []
        for here, there in ((0, 1), (1, 0)):
            found = compare(maps[here], maps[there], library.poolings, library.products)
            if tests:
                found |= compare_sets(maps[here], tests[here], tests[there], largest, library.products)
            yield found


def compare(
    here: UtilityMap, there: UtilityMap, poolings: Sequence[Pooling], products: np.ndarray
) -> dict[str, float]:
    best = int(here.expected_mean.argmax())
    product = int(np.where(products, here.expected_mean, -1).argmax())
    smoothed = (one.apply(here.mean[None], share)[0] for one in poolings for share in SHARES)
    average = there.mean.mean()
    return {
        "promise": float(here.expected_mean[best]),
        "delivery": float(there.mean[best]),
        "gain": float(there.mean[best] - average),
        "product's promise": float(here.expected_mean[product]),
        "product's delivery": float(there.mean[product]),
        "product's gain": float(there.mean[product] - average),
        "by F1": float(there.mean[here.mean.argmax()] - average),
        "oracle": float(there.mean.max() - average),
        "rho": rank_correlation(here.expected_mean, there.mean),
        "ceiling": float(np.sqrt(max(rank_correlation(here.mean, there.mean), 0.0))),
        "hindsight": max(rank_correlation(one, there.mean) for one in smoothed),
        "chance": here.beats_average,
        "better": float(there.mean[best] > average),
        "holds": float(((here.expected_low <= there.mean) & (there.mean <= here.expected_high)).mean()),
        "as good": float(here.as_good.mean()),
        "ranks": float(here.can_rank),
    }


def compare_sets(
    utility: UtilityMap, here: SetTests, there: SetTests, largest: int, products: np.ndarray
) -> dict[str, float]:
    terms = checked_terms(len(utility.f1), largest)
    on_products = replace(terms, allowed=products)
    by_luck = chance(there, terms)
    ways = {
        "of": (terms, chosen(utility, here, terms), ByHalves()),
        "on products, of": (on_products, chosen(utility, here, on_products), ByHalves()),
        "of the proxy's": (terms, greedy_order(utility.f1, terms), greedy_by_half),
    }
    found = {}
    for way, (under, order, choose) in ways.items():
        alone = tuple(float(one[order[0]]) for one in utility.expected)
        made = Promises(here, under).of(order, choose, alone)
        delivered = macro_f1(there, order)
        of_size = {
            "promise": made.mean,
            "delivery": delivered,
            "gain": delivered - by_luck[: len(order)],
            "naive": np.nanmean(made.raw, axis=1),
        }
        if "proxy" in way:
            of_size["mean-max"] = np.maximum.accumulate(utility.f1[list(order)], axis=0).mean(axis=1)
        for number in range(2, largest + 1):
            for what, values in of_size.items():
                found[f"{what} {way} {number}"] = float(values[min(number, len(values)) - 1])
    return found


def chosen(utility: UtilityMap, tests: SetTests, terms: Terms) -> Sequence[int]:
    """The patches that a run would choose, in their order."""
    return GrownSet(tests.whole, terms, utility.expected_mean).up_to(terms.max_size)


def macro_f1(tests: SetTests, order: Sequence[int]) -> np.ndarray:
    """Of the first patch, the first two, and so on, shape (K,)."""
    return np.nanmean(tests.whole.f1_of_first(order), axis=1)


def chance(tests: SetTests, terms: Terms) -> np.ndarray:
    """Macro F1 of sets drawn at random, by size, shape (K,)."""
    drawn = random_sets(terms, terms.max_size, seed=99)
    return np.nanmean([tests.whole.f1_of_first(one) for one in drawn], axis=(0, 2))


def rank_correlation(one: np.ndarray, other: np.ndarray) -> float:
    return float(spearmanr(one, other)[0]) if np.ptp(one) > 0 and np.ptp(other) > 0 else np.nan


def calibration(found: Sequence[dict[str, float]]) -> Iterator[str]:
    """Chances of beating an average patch, stated and found, in lines."""
    stated, better = (np.array([row[key] for row in found]) for key in ("chance", "better"))
    for low, high in itertools.pairwise(CHANCES):
        some = (stated >= low) & (stated < high)
        if some.any():
            means = f"{stated[some].mean():.3f}, {better[some].mean():.3f}"
            yield f"{low:.2f} to {high:.2f}: {some.sum()} times, {means}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--only", nargs="*", choices=CASES, default=list(CASES))
    parser.add_argument("--halvings", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--sets", type=int, default=4)
    parser.add_argument("--patches", type=int, default=512)
    parser.add_argument("--classifier", choices=CLASSIFIERS, default=Ridge.name)
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--shuffled", action=argparse.BooleanOptionalAction, default=True)
    given = parser.parse_args()
    if given.sets > 1 and given.classifier != Ridge.name:
        parser.error("sets are of the ridge alone: --sets 0")
    given.scratch.mkdir(parents=True, exist_ok=True)
    every = []
    for name in given.only:
        library = prepared(name, given.scratch, given.workers, given.patches, given.classifier)
        ways = (False, True) if CASES[name].subjects else (False,)
        for by_subject, shuffle in itertools.product(ways, (False, True) if given.shuffled else (False,)):
            found = []
            for row in judged(library, by_subject, given.halvings, shuffle, given.sets):
                found.append(row)
                if given.rows:
                    with given.rows.open("a", encoding="utf-8") as stream:
                        of = {"library": name, "by_subject": by_subject, "shuffled": shuffle}
                        stream.write(json.dumps(of | row) + "\n")
            every += [] if shuffle else found
            mean = {key: np.nanmean([row[key] for row in found]) for key in found[0]}
            words = "  ".join(f"{key} {value:.3f}" for key, value in mean.items())
            kind = f"by {'subject' if by_subject else 'clip'}{', shuffled' if shuffle else ''}"
            print(f"{name} {kind}: {words}", flush=True)
    print("Chance of beating an average patch: how often stated, mean stated, found")
    print("\n".join(calibration(every)))


if __name__ == "__main__":
    main()
