# SPDX-License-Identifier: GPL-3.0-or-later
"""A library of many clips: where a clip's time goes, and how time and memory grow with clips and workers.

    python -m benchmarks.library make FOLDER --clips 589      # real Mixamo files and variants of them
    python -m benchmarks.library links FOLDER FROM --clips 5000      # the same files under more names
    python -m benchmarks.library road FOLDER [--files 60]
    python -m benchmarks.library scale FOLDER --clips 147 294 589 --workers 1 2
    python -m benchmarks.library scale FOLDER --clips 147 --dask 2
    python -m benchmarks.library halves FOLDER --clips 588

`road` takes a sample of the files. Each goes the whole way from file to stored signals and, in turn, through
`import_scene.fbx`, Blender's importer in Python, in the same process; printed are the ratio of the two and a
table of where our time goes. `scale` runs `w2w run` on the first clips of the library and prints clips an
hour, while signals are made and from start to end, the seconds of the steps, the processor time of all and
of the workers alone, and the peak memory of the parent, the largest worker and all processes together. What
the workers waited for a processor that other programs had (Linux counts it) is taken off where it says so.
With `--dask` the clips go through a scheduler and so many workers on this machine, started for it beforehand.
`halves` makes the signals of half the clips in each of two runs of one worker at the same time, runs that
share nothing: how much two workers could do at best on this machine.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

from tests.robustness.fbx_variants import LABELS, write_library

from .library_road import road
from .watched_run import Seen, cluster, run_arguments, watched

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
SIGNALS = "Motions to signals"
STEPS = ("Placing patches on the body", SIGNALS, "Ranking patches", "Testing the sensors together")


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    make = commands.add_parser("make")
    make.add_argument("folder", type=Path)
    make.add_argument("--clips", type=int, default=589)
    make.add_argument("--data", type=Path, default=DATA)
    links = commands.add_parser("links")
    links.add_argument("folder", type=Path)
    links.add_argument("source", type=Path)
    links.add_argument("--clips", type=int, default=5000)
    way = commands.add_parser("road")
    way.add_argument("folder", type=Path)
    way.add_argument("--files", type=int, default=60)
    grow = commands.add_parser("scale")
    grow.add_argument("folder", type=Path)
    grow.add_argument("--clips", type=int, nargs="+", default=[147, 294, 589])
    grow.add_argument("--workers", type=int, nargs="*", default=[])
    grow.add_argument("--dask", type=int, nargs="*", default=[], help="Workers of a cluster on this machine.")
    grow.add_argument("--out", type=Path, help="Where the results of the runs go; else a temporary folder.")
    apart = commands.add_parser("halves")
    apart.add_argument("folder", type=Path)
    apart.add_argument("--clips", type=int, default=588)
    choice = parser.parse_args()
    if choice.command == "make":
        print(write_library(choice.folder, choice.data, choice.clips), "clips in", choice.folder)
    elif choice.command == "links":
        link_library(choice.folder, choice.source, choice.clips)
    elif choice.command == "road":
        road(choice.folder, choice.files)
    elif choice.command == "halves":
        halves(choice.folder, choice.clips)
    else:
        scale(choice.folder, choice.clips, choice.workers, choice.dask, choice.out)


def link_library(folder: Path, source: Path, clips: int) -> None:
    """A library of more names: hard links to the files of another, again and again."""
    rows = _labels(source)
    named = []
    for number in range(clips):
        file, activity, key = rows[number % len(rows)]
        path = Path(file)
        name = path.with_name(f"{path.stem} lap {number // len(rows)}{path.suffix}").as_posix()
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            target.hardlink_to(source / file)
        named.append((name, activity, key))
    _write_labels(folder / LABELS, named)
    print(clips, "clips in", folder)


def scale(folder: Path, sizes: list[int], workers: list[int], dask: list[int], out: Path | None) -> None:
    """Run libraries of several sizes with several numbers of workers, and print a table."""
    rows = _labels(folder)
    print(
        "  clips  workers  placing s  signals s: wall  less waiting  clips/h  ranking s  together s  whole s"
        "  clips/h  processor s: own  of workers  peak MB: parent  a worker  all together"
    )
    for n_clips in sizes:
        for number, distributed in [*((number, False) for number in workers), *((n, True) for n in dask)]:
            with ExitStack() as stack:
                place = Path(stack.enter_context(tempfile.TemporaryDirectory(dir=out)))
                options, others = ["--workers", str(number)], []
                if distributed:
                    options, others = stack.enter_context(cluster(number))
                seen = _run(folder, place, rows[:n_clips], options, others)
            placing, signals, ranking, together = (seen.steps.get(step, float("nan")) for step in STEPS)
            name = f"{number} Dask" if distributed else str(number)
            memory = "  ".join(f"{peak / 1e6:8.0f}" for peak in (seen.parent, seen.worker, seen.together))
            alone = signals - seen.waited
            print(
                f"{n_clips:7d}  {name:>7s}  {placing:9.1f}  {signals:15.1f}  {alone:12.1f}  "
                f"{3600 * n_clips / alone:7.0f}  {ranking:9.1f}  {together:10.1f}  {seen.whole:7.1f}  "
                f"{3600 * n_clips / seen.whole:7.0f}  {seen.own:16.1f}  {seen.of_workers:10.1f}  {memory}",
                flush=True,
            )


def halves(folder: Path, clips: int) -> None:
    """Two runs at once, with one worker and half the clips each: the most that two workers can do."""
    rows = _labels(folder)[:clips]
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(2) as pool:
        parts = [(Path(place) / str(first), rows[first::2]) for first in range(2)]
        for own, _ in parts:
            own.mkdir()
        seen = list(pool.map(lambda part: _run(folder, *part, ["--workers", "1"]), parts))
    signals = [run.steps[SIGNALS] for run in seen]
    alone = [run.steps[SIGNALS] - run.waited for run in seen]
    print(f"{len(rows)} clips by two runs at once: signals in {signals[0]:.1f} and {signals[1]:.1f} s")
    print(f"less waiting for a processor: {alone[0]:.1f} and {alone[1]:.1f} s,", end=" ")
    print(f"{3600 * len(rows) / max(alone):.0f} clips/h")
    print(f"processor time of the workers: {sum(run.of_workers for run in seen):.1f} s")


def _run(
    folder: Path,
    place: Path,
    rows: list[tuple[str, str, str]],
    options: list[str],
    others: Sequence[int] = (),
) -> Seen:
    """`w2w run` on some rows of a library, into a new folder."""
    _write_labels(place / "labels.csv", rows)
    return watched(run_arguments(folder, place / "labels.csv", place / "out", options), others)


def _labels(folder: Path) -> list[tuple[str, str, str]]:
    with (folder / LABELS).open(newline="", encoding="utf-8") as stream:
        return [(row["file"], row["activity"], row["motion_key"]) for row in csv.DictReader(stream)]


def _write_labels(path: Path, rows: list[tuple[str, str, str]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([("file", "activity", "motion_key"), *rows])


if __name__ == "__main__":
    main()
