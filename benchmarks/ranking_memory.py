# SPDX-License-Identifier: GPL-3.0-or-later
"""Peak memory of ranking patches, by the number of clips: it shall not grow with the library.

    python -m benchmarks.ranking_memory [--clips 589 5000] [--patches 64] [--windows 5] [--sets] [--dask 0]

Each size is ranked in a process of its own with workers of its own, as by `w2w run`, from feature files as
it leaves them: random features with a trace of the activity, hard links to as many files as fit in 100 MB.
Printed are the features' size, the peak resident memory and processor time of the process, and those of its
workers (the largest peak). More patches mean more blocks, not larger ones.
With `--sets` two sensors to wear together are chosen as well. With `--dask N` the patches are tried by N
workers of a Dask scheduler on this machine, as `w2w run --scheduler` has them tried.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import subprocess
import sys
import tempfile
from contextlib import closing, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.files import write_npz
from w2w.core.motion.signature import WIDTH
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map
from w2w.core.selection.joint import GrownSet
from w2w.core.study.clip_files import NO_SIGNATURE, ClipWindows, Signatures
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip, WindowLabels, same_motions, set_tests_of
from w2w.core.windows.features import feature_names
from w2w.core.windows.inputs import FeatureFiles
from w2w.headless.runs.cluster import spread_over
from w2w.headless.runs.workers import Crew, spread_here
from w2w_studies.paper.subsets import checked_terms

ACTIVITIES = 24
DISTINCT_BYTES = 100 * 2**20


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--clips", type=int, nargs="+", default=[589, 5000])
    parser.add_argument("--patches", type=int, default=64)
    parser.add_argument("--windows", type=int, default=5)
    parser.add_argument("--sets", action="store_true")
    parser.add_argument("--dask", type=int, default=0, metavar="WORKERS")
    parser.add_argument("--scheduler", default="", help=argparse.SUPPRESS)
    parser.add_argument("--rank", type=Path, help=argparse.SUPPRESS)
    choice = parser.parse_args()
    if choice.rank is not None:
        _rank(choice)
        return
    print("  clips   features MB   peak MB   processor s   workers' peak MB   processor s")
    for n_clips in choice.clips:
        with tempfile.TemporaryDirectory() as place:
            size = _write_features(Path(place), n_clips, choice.windows, choice.patches)
            with _cluster(choice.dask) as cluster:
                said = _in_its_own_process(Path(place), n_clips, choice, cluster)
                theirs = cluster.get_client().run(_used).values() if cluster else []
        peak = max((one for one, _ in theirs), default=said[2])
        seconds = sum(one for _, one in theirs) or said[3]
        print(f"{n_clips:7d}   {size / 1e6:11.0f}   {said[0]:7.0f}   {said[1]:11.1f}", end="")
        print(f"   {peak:16.0f}   {seconds:11.1f}", flush=True)


def _cluster(workers: int) -> Any:
    """A Dask scheduler with so many workers on this machine, or nothing."""
    if not workers:
        return nullcontext()
    from distributed import LocalCluster

    return LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)


def _in_its_own_process(place: Path, n_clips: int, choice: argparse.Namespace, cluster: Any) -> list[float]:
    command = [
        sys.executable, "-m", "benchmarks.ranking_memory",
        "--rank", place, "--clips", str(n_clips), "--windows", str(choice.windows),
        *(["--sets"] if choice.sets else []),
        *(["--scheduler", cluster.scheduler_address] if cluster else []),
    ]  # fmt: skip
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [float(one) for one in said.split()]


def _used(whose: int = resource.RUSAGE_SELF) -> tuple[float, float]:
    """Peak memory (MB) and processor time (s), this process's or its ended workers'."""
    used = resource.getrusage(whose)
    return used.ru_maxrss / 1000, used.ru_utime + used.ru_stime


def _write_features(place: Path, n_clips: int, windows: int, patches: int) -> int:
    rng = np.random.default_rng(0)
    shape = (windows, patches, len(feature_names(100, 50.0)))
    size = 4 * int(np.prod(shape))
    distinct = max(ACTIVITIES, DISTINCT_BYTES // size // ACTIVITIES * ACTIVITIES)
    trace = rng.normal(size=(ACTIVITIES, shape[2]))
    for number in range(n_clips):
        path = place / f"{number}.npz"
        if number < distinct:
            features = rng.normal(size=shape) + 0.2 * trace[number % ACTIVITIES]
            write_npz(path, {"features": features.astype(np.float32)})
        else:
            path.hardlink_to(place / f"{number % distinct}.npz")
    return n_clips * size


def _rank(choice: argparse.Namespace) -> None:
    """Rank, choose a pair where sets are wanted, and print peak memory (MB) and processor time (s)."""
    place, n_clips, windows = choice.rank, choice.clips[0], choice.windows
    rng = np.random.default_rng(1)
    found = [ClipWindows(np.arange(windows) % 2 == 0, NO_SIGNATURE)] * n_clips
    clips = [LabelledClip(str(number), f"activity {number % ACTIVITIES}", "") for number in range(n_clips)]
    files = FeatureFiles([place / f"{number}.npz" for number in range(n_clips)])
    config = StudyConfig()
    with closing(Signatures(place)) as signatures:
        for _ in clips:
            signatures.append(rng.normal(size=100 * WIDTH))
        labels = WindowLabels.of(same_motions(clips, found, signatures), found)
    here = spread_here(multiprocessing.cpu_count(), Crew())
    spread = spread_over(choice.scheduler) or here
    utility = utility_map(files, labels.protocol(config), spread=spread)
    if choice.sets:
        tests = set_tests_of(files, labels, config, Pooling.none(files.shape[1]))
        GrownSet(tests.whole, checked_terms(len(utility.mean), 2), utility.expected_mean).up_to(2)
    print(*_used(), *_used(resource.RUSAGE_CHILDREN))


if __name__ == "__main__":
    main()
