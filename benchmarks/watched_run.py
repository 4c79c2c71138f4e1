# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run` as a benchmark sees it from outside: seconds, processor time and memory of all its processes."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil

EVERY_S = 0.2
STEP = re.compile(r"^([A-Z][^:\n]*): ([0-9.]+) s *$", re.MULTILINE)


@dataclass(frozen=True)
class Seen:
    """What a run took.

    Parameters
    ----------
    steps : dict of str to float
        Wall-clock seconds of the steps that it told of.
    whole : float
        Wall-clock seconds from start to end.
    own, of_workers : float
        Processor seconds of the run's own process and of its workers.
    waited : float
        Seconds that a worker waited for a processor on average, while others had it.
    parent, worker, together : int
        Peak resident bytes of the run's own process, of its largest worker, and of all at once.
    """

    steps: dict[str, float]
    whole: float
    own: float
    of_workers: float
    waited: float
    parent: int
    worker: int
    together: int


def run_arguments(library: Path, labels: Path, out: Path, options: Sequence[str]) -> list[str]:
    """The command for a run on the clips that a csv lists."""
    return [
        sys.executable, "-m", "headless", "run", str(library), "--labels", str(labels), "--out", str(out),
        "--no-pictures", *options,
    ]  # fmt: skip


def watched(command: Sequence[str], others: Sequence[int] = ()) -> Seen:
    """Run a command to its end and look at it every now and then.

    Parameters
    ----------
    command : sequence of str
    others : sequence of int
        Processes that work for it without being its children, such as a cluster's.

    Raises
    ------
    SystemExit
        If it fails.
    """
    before = {pid: _processor_s(pid) for root in others for pid in (root, *_children(root))}
    waited_before = {pid: _waited_s(pid) for pid in before}
    start = time.perf_counter()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT)
        own, parent, worker, together = 0.0, 0, 0, 0
        spent: dict[int, float] = {}
        waits: dict[int, float] = {}
        while process.poll() is None:
            own = max(own, _processor_s(process.pid))
            size = _resident(process.pid)
            sizes = []
            for pid in (*_children(process.pid), *(p for root in others for p in (root, *_children(root)))):
                spent[pid] = max(spent.get(pid, 0.0), _processor_s(pid) - before.get(pid, 0.0))
                waits[pid] = max(waits.get(pid, 0.0), _waited_s(pid) - waited_before.get(pid, 0.0))
                sizes.append(_resident(pid))
            parent, worker = max(parent, size), max(worker, *sizes, 0)
            together = max(together, size + sum(sizes))
            time.sleep(EVERY_S)
        whole = time.perf_counter() - start
        said.seek(0)
        text = said.read()
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)} ended with {process.returncode}:\n{text[-2000:]}")
    steps = {name: float(value) for name, value in STEP.findall(text)}
    worked = [pid for pid, seconds in spent.items() if seconds > 0.2 * max(spent.values())]
    waited = sum(waits[pid] for pid in worked) / max(1, len(worked))
    return Seen(steps, whole, own, sum(spent.values()), waited, parent, worker, together)


@contextmanager
def cluster(workers: int) -> Iterator[tuple[list[str], list[int]]]:
    """A Dask scheduler and so many workers over loopback: the options to use them, and their processes."""
    from distributed import Client

    with tempfile.TemporaryDirectory() as place:
        address = Path(place) / "scheduler.json"
        dask = [sys.executable, "-m", "dask"]
        commands = [[*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]]
        commands += [[*dask, "worker", "--nthreads", "1", "--no-dashboard"]] * workers
        processes = [
            subprocess.Popen(
                [*command, "--scheduler-file", str(address)],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            for command in commands
        ]
        try:
            while not address.exists():
                time.sleep(EVERY_S)
            with Client(scheduler_file=str(address)) as client:
                client.wait_for_workers(workers, timeout=60)
            yield ["--scheduler", str(address)], [process.pid for process in processes]
        finally:
            for process in reversed(processes):
                process.terminate()
                process.wait()


def _children(pid: int) -> list[int]:
    try:
        return [child.pid for child in psutil.Process(pid).children(recursive=True)]
    except psutil.Error:
        return []


def _resident(pid: int) -> int:
    try:
        return psutil.Process(pid).memory_info().rss
    except psutil.Error:
        return 0


def _processor_s(pid: int) -> float:
    """Processor seconds of a process so far; without those of its children."""
    try:
        times = psutil.Process(pid).cpu_times()
    except psutil.Error:
        return 0.0
    return times.user + times.system


def _waited_s(pid: int) -> float:
    """Seconds that the busiest thread of a process has stood in line for a processor; 0 where none tells."""
    threads = []
    for path in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        try:
            ran, waited, _ = map(int, path.read_text().split())
        except (OSError, ValueError):
            continue
        threads.append((ran, waited))
    return max(threads, default=(0, 0))[1] / 1e9
