# SPDX-License-Identifier: GPL-3.0-or-later
"""A library of many clips: where a clip's time goes, and how time and memory grow with clips and workers.

    python -m benchmarks.library make FOLDER --clips 589      # real Mixamo files and variants of them
    python -m benchmarks.library links FOLDER FROM --clips 5000      # the same files under more names
    python -m benchmarks.library road FOLDER [--files 60]
    python -m benchmarks.library scale FOLDER --clips 147 294 589 --workers 1 2

`road` takes a sample of the files. Each goes the whole way from file to stored signals and, in turn, through
`import_scene.fbx`, Blender's importer in Python, in the same process; printed are the ratio of the two and a
table of where our time goes. `scale` runs `w2w run` on the first clips of the library and prints clips an
hour, the time of each step, the processor time of all, and the peak memory of the parent, the largest
worker and all processes together.
"""

from __future__ import annotations

import argparse
import csv
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

from .fbx_variants import LABELS, write_library
from .library_road import road

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
EVERY_S = 0.2
STEP = re.compile(r"^(Motions to signals|Ranking places): ([0-9.]+) s", re.MULTILINE)


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
    grow.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    grow.add_argument("--out", type=Path, help="Where the results of the runs go; else a temporary folder.")
    choice = parser.parse_args()
    if choice.command == "make":
        print(write_library(choice.folder, choice.data, choice.clips), "clips in", choice.folder)
    elif choice.command == "links":
        link_library(choice.folder, choice.source, choice.clips)
    elif choice.command == "road":
        road(choice.folder, choice.files)
    else:
        scale(choice.folder, choice.clips, choice.workers, choice.out)


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


def scale(folder: Path, sizes: list[int], workers: list[int], out: Path | None) -> None:
    """Run libraries of several sizes with several numbers of workers, and print a table."""
    rows = _labels(folder)
    print(
        "  clips  workers  signals s  clips/h  ranking s  processor s  a clip"
        "  peak MB: parent  a worker  all together"
    )
    for n_clips in sizes:
        for n_workers in workers:
            with tempfile.TemporaryDirectory(dir=out) as place:
                labels = Path(place) / "labels.csv"
                _write_labels(labels, rows[:n_clips])
                command = [
                    sys.executable, "-m", "headless", "run", str(folder), "--labels", str(labels),
                    "--out", f"{place}/out", "--workers", str(n_workers), "--no-pictures",
                ]  # fmt: skip
                before = _processor_seconds()
                seconds, peaks = _watched(command)
                spent = _processor_seconds() - before
            baking = seconds.get("Motions to signals", float("nan"))
            ranking = seconds.get("Ranking places", float("nan"))
            memory = "  ".join(f"{peak / 1e6:8.0f}" for peak in peaks)
            per_hour = 3600 * n_clips / baking
            print(
                f"{n_clips:7d}  {n_workers:7d}  {baking:9.1f}  {per_hour:7.0f}  {ranking:9.1f}  "
                f"{spent:11.1f}  {spent / n_clips:6.3f}  {memory}",
                flush=True,
            )


def _processor_seconds() -> float:
    """Processor time of all processes that have ended under this one: what a busy machine leaves as it is."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _watched(command: list[str]) -> tuple[dict[str, float], tuple[int, int, int]]:
    """Run a command; the seconds of its steps, and peak resident bytes of parent, worker and all."""
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT)
        parent, worker, together = 0, 0, 0
        while process.poll() is None:
            own, others = _resident(process.pid)
            parent = max(parent, own)
            worker = max(worker, max(others, default=0))
            together = max(together, own + sum(others))
            time.sleep(EVERY_S)
        said.seek(0)
        text = said.read()
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)} ended with {process.returncode}:\n{text}")
    return {name: float(value) for name, value in STEP.findall(text)}, (parent, worker, together)


def _resident(pid: int) -> tuple[int, list[int]]:
    """Resident bytes of a process, and of each of its descendants."""
    try:
        process = psutil.Process(pid)
        own = process.memory_info().rss
        children = process.children(recursive=True)
    except psutil.Error:
        return 0, []
    sizes = []
    for child in children:
        try:
            sizes.append(child.memory_info().rss)
        except psutil.Error:
            continue
    return own, sizes


def _labels(folder: Path) -> list[tuple[str, str, str]]:
    with (folder / LABELS).open(newline="", encoding="utf-8") as stream:
        return [(row["file"], row["activity"], row["motion_key"]) for row in csv.DictReader(stream)]


def _write_labels(path: Path, rows: list[tuple[str, str, str]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([("file", "activity", "motion_key"), *rows])


if __name__ == "__main__":
    main()
