# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading a run's features some patches at a time: `StoredArray` against what NumPy offers.

    python -m benchmarks.stored_columns RESULTS [--clips 600] [--budget 32] [--rounds 3]

RESULTS is the folder of a finished `w2w run`. Its feature files are linked until there are as many clips as
asked for, and read through once in blocks of patches that keep to the budget (MB), as the ranking does:

    stored     `FeatureFiles`, the run's own files, a row of an array's columns at a time
    load       the baseline: `np.load(file)["features"][:, first:last]`, which reads all for each block
    unpacked   `np.load(file, mmap_mode="r")[:, first:last]` of an npy written beside each npz beforehand

Each way is read in a process of its own, in turn, as often as there are rounds; printed are the medians of
wall and processor time, the peak resident memory, and the ratios of the times to the baseline's. All digests
of what was read must be equal. Files stand in the page cache after the first pass, which is not counted.
"""

from __future__ import annotations

import argparse
import hashlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from w2w.core.windows.inputs import FeatureFiles, spans

WAYS = ("load", "stored", "unpacked")


class Loaded:
    """Features by `np.load` of each whole array, or of an npy mapped by it."""

    def __init__(self, files: FeatureFiles, paths: list[Path], mapped: bool) -> None:
        self.shape, self._paths, self._mapped = files.shape, paths, mapped

    def patches(self, which: slice) -> np.ndarray:
        """Features of some patches, shape (W, P, D)."""
        block = np.empty((self.shape[0], which.stop - which.start, self.shape[2]), dtype=np.float32)
        start = 0
        for path in self._paths:
            part = self._part(path)[:, which]
            block[start : start + len(part)] = part
            start += len(part)
        return block

    def _part(self, path: Path) -> np.ndarray:
        if self._mapped:
            return np.load(path.with_suffix(".npy"), mmap_mode="r", allow_pickle=False)
        with np.load(path, allow_pickle=False) as data:
            return data["features"]


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--clips", type=int, default=600)
    parser.add_argument("--budget", type=int, default=32, help="MB")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--way", choices=WAYS, help=argparse.SUPPRESS)
    choice = parser.parse_args()
    if choice.way:
        _read(choice.results, choice.way, choice.budget * 2**20)
        return
    found = sorted((choice.results / ".w2w" / "features").glob("*.npz"))
    if not found:
        parser.error(f"{choice.results} holds no features: give the folder of a finished run")
    with tempfile.TemporaryDirectory(dir=choice.results.resolve().parent) as folder:
        _link(found, Path(folder), choice.clips)
        _compare(Path(folder), choice.budget, choice.rounds)


def _link(found: list[Path], folder: Path, n_clips: int) -> None:
    for number in range(n_clips):
        target = folder / f"{number:06d}.npz"
        if number < len(found):
            target.hardlink_to(found[number])
            with np.load(target, allow_pickle=False) as data:
                np.save(target.with_suffix(".npy"), data["features"])
        else:
            for ending in (".npz", ".npy"):
                target.with_suffix(ending).hardlink_to(folder / f"{number % len(found):06d}{ending}")


def _compare(folder: Path, budget: int, rounds: int) -> None:
    files = FeatureFiles(sorted(folder.glob("*.npz")))
    size, blocks = 4 * np.prod(files.shape), len(spans(files, budget * 2**20))
    print(f"{files.shape[0]} windows of {files.shape[1]} patches, {size / 1e6:.0f} MB, in {blocks} blocks\n")
    said: dict[str, list[list[str]]] = {way: [] for way in WAYS}
    for number in range(rounds + 1):
        for way in WAYS:
            command = [sys.executable, "-m", "benchmarks.stored_columns", str(folder), "--way", way]
            done = subprocess.run(
                [*command, "--budget", str(budget)], check=True, capture_output=True, text=True
            ).stdout.split()
            if number:
                said[way].append(done)
    if len({row[3] for rows in said.values() for row in rows}) != 1:
        sys.exit("the ways read different values")
    print("way         wall s   ratio   processor s   ratio   peak MB")
    medians = {
        way: [statistics.median(float(row[n]) for row in rows) for n in range(3)]
        for way, rows in said.items()
    }
    base_wall, base_processor, _ = medians["load"]
    for way, (wall, processor, peak) in medians.items():
        ratios = f"{wall / base_wall:5.2f}", f"{processor / base_processor:5.2f}"
        print(f"{way:9s} {wall:8.2f}   {ratios[0]}   {processor:11.2f}   {ratios[1]}   {peak:7.0f}")


def _read(folder: Path, way: str, budget: int) -> None:
    """Read all blocks; print wall and processor time (s), peak memory (MB) and a digest."""
    paths = sorted(folder.glob("*.npz"))
    files = FeatureFiles(paths)
    digest = hashlib.blake2b()
    wall = processor = 0.0
    source = files if way == "stored" else Loaded(files, paths, mapped=way == "unpacked")
    for span in spans(files, budget):
        begun = time.perf_counter(), time.process_time()
        block = source.patches(span)
        wall += time.perf_counter() - begun[0]
        processor += time.process_time() - begun[1]
        digest.update(block)
        del block
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    print(wall, processor, peak, digest.hexdigest())


if __name__ == "__main__":
    main()
