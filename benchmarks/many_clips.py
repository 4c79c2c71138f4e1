# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run's own process does for each clip of a large library: made clips, and hardly any work on each.

    python -m benchmarks.many_clips SCRATCH [--clips 1000 10000] [--patches 16]

The work on a clip is done once and copied with noise, and with a smooth movement of its own for telling
copies; all else is a run's: records, gathering, telling copies, ranking, tables. Printed are processor
seconds, a clip's and each further clip's beyond the smaller library, what the same command takes once there
is nothing to do and once one clip has changed, and peak memory. SCRATCH takes 60 kB a clip.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.motion.motion import Motion
from w2w.core.motion.signature import RATE, WIDTH
from w2w.core.study.clip_files import write_features
from w2w.headless.runs import clip as on_clip, study
from w2w.headless.runs.records import unfinished
from w2w.headless.start import main as w2w

ACTIVITIES, FRAMES, POSES, MOVES = 10, 24, 41, 8


def make(folder: Path, clips: int) -> None:
    """A library of made clips, each its own motion of a few joints."""
    rng = np.random.default_rng(0)
    for number in range(clips):
        path = folder / f"activity {number % ACTIVITIES}" / f"{number:06d}.npz"
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            move(path, number, rng)


def move(path: Path, number: int, rng: np.random.Generator) -> None:
    """Write a clip in which a joint turns to and fro."""
    turns = 0.3 * np.sin(2 * np.pi * rng.uniform(0.3, 2) * np.arange(FRAMES) / 30 + rng.uniform(0, 6))
    rotations = np.tile(np.eye(3), (FRAMES, 24, 1, 1))
    rotations[:, 1 + number % 20, 0, 0] = rotations[:, 1 + number % 20, 1, 1] = np.cos(turns)
    rotations[:, 1 + number % 20, 1, 0] = np.sin(turns)
    rotations[:, 1 + number % 20, 0, 1] = -np.sin(turns)
    Motion(rotations, np.tile([0.0, 0.0, 0.95], (FRAMES, 1)), 30.0).save(path)


def in_turn(due: list[Any], _workers: int, _scheduler: str, made: Callable[..., None], _crew: Any) -> None:
    """What stands in for `run_tasks`: no workers, and the work on the first clip copied with noise."""
    rng, held, make_one = np.random.default_rng(len(due)), {}, on_clip._make

    def copied(task: Any) -> tuple[dict[str, Any], tuple[Path, ...]]:
        if not held:
            details, files = make_one(task)
            with np.load(task.features_file, allow_pickle=False) as first:
                held.update(first, details=details, motion=unfinished(files[0]).read_bytes())
        features = held["features"] + 0.3 * rng.normal(size=held["features"].shape)
        features[..., int(task.clip.activity[-1])] += 1
        phases = 2 * np.pi * np.arange(POSES)[:, None] / RATE
        swings = np.sin(phases * rng.uniform(0.3, 2, MOVES) + rng.uniform(0, 6, MOVES))
        signature = held["signature"][:WIDTH] + swings @ rng.normal(scale=0.2, size=(MOVES, WIDTH))
        arrays = (
            features.astype(np.float32),
            held["is_test"],
            signature.astype(held["signature"].dtype).ravel(),
        )
        write_features(task.features_file, *arrays)
        unfinished(task.motion_file).write_bytes(held["motion"])
        return held["details"], (task.motion_file, task.features_file)

    on_clip._make = copied
    for task in due:
        made(on_clip.do_clip(task))


def run(folder: Path, clips: int, patches: int) -> None:
    """One run, in a process of its own; prints processor seconds, with its workers', and peak memory (kB)."""
    study.run_tasks = in_turn
    keep = ["--no-signals", "--no-pictures", "--no-report", "--patches", str(patches)]
    sys.argv = ["w2w", "run", str(folder / f"library {clips}"), "--out", str(folder / f"out {clips}"), *keep]
    try:
        w2w()
    finally:
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        spent = sum(one.ru_utime + one.ru_stime for one in used)
        print(f"\nspent {spent} {used[0].ru_maxrss}", flush=True)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--clips", type=int, nargs="+", default=[1000, 10000])
    parser.add_argument("--patches", type=int, default=16)
    parser.add_argument("--run", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.run:
        run(given.scratch, given.run, given.patches)
        return
    print("  clips   processor s   a clip, ms   each more, ms   nothing to do, s   one changed, s   peak MB")
    before = (0, 0.0)
    for clips in given.clips:
        library = given.scratch / f"library {clips}"
        make(library, clips)
        command = [sys.executable, "-m", "benchmarks.many_clips", str(given.scratch), "--run", str(clips)]
        figures = []
        for number in range(3):
            if number == 2:
                move(next(library.glob("*/*.npz")), 0, np.random.default_rng(1))
            said = subprocess.run(
                [*command, "--patches", str(given.patches)], check=True, capture_output=True, text=True
            ).stdout
            figures.append([float(word) for word in said.rpartition("spent ")[2].split()])
        (spent, peak), (again, _), (changed, _) = figures
        more = 1e3 * (spent - before[1]) / (clips - before[0])
        print(
            f"{clips:7d} {spent:13.1f} {1e3 * spent / clips:12.2f} {more:15.2f} {again:18.1f} "
            f"{changed:16.1f} {peak / 1e3:9.0f}",
            flush=True,
        )
        before = (clips, spent)


if __name__ == "__main__":
    main()
