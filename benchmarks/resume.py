# SPDX-License-Identifier: GPL-3.0-or-later
"""Kill a run at random moments and let the same command go on: are the bytes those of an undisturbed run?

    python -m benchmarks.resume [--kills 200] [--in-a-row 4] [--seed 0] [--json OUT.json]

`w2w run` on four real clips is killed with all its workers (SIGKILL, which nothing can catch) at a moment
drawn evenly from its life; what goes on from there is killed again, up to so many times in a row, and then
left to finish. Printed are the kills, how many clips were finished then, and how often bytes differed,
half-written files stayed behind or a finished clip was done again: 0, or it is a fault.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shutil
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from blender_addon.w2w.core.files import write_json
from headless.__main__ import main as main_command

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data" / "mixamo"
CLIPS = {
    "Conqster__TheBarMan/Walking.fbx": "walking",
    "M3-org__CharacterStudio/StrutWalking.fbx": "walking",
    "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Run.fbx": "running",
    "kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx": "running",
}
UNLIKE = ("state.json", "holder", "lock")
"""Files that tell of the run itself."""


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--in-a-row", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    choice = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        found = kill_and_resume(Path(place), choice.kills, choice.in_a_row, choice.seed)
    print(", ".join(f"{name}: {count}" for name, count in sorted(found.items())))
    if choice.json is not None:
        write_json(choice.json, found)
    if any(name.startswith("FAULT") for name in found):
        raise SystemExit(1)


def kill_and_resume(place: Path, kills: int, in_a_row: int, seed: int) -> Counter[str]:
    """Kill runs so often, letting one finish after each so many; what happened, counted."""
    library = place / "library"
    for file, activity in CLIPS.items():
        (library / activity).mkdir(parents=True, exist_ok=True)
        shutil.copy(DATA / file, library / activity)
    rng = np.random.default_rng(seed)
    start = time.monotonic()
    _Run(library, place / "undisturbed", 2).wait()
    life = time.monotonic() - start
    expected = hashes(place / "undisturbed")
    counted: Counter[str] = Counter()
    while counted["killed"] < kills:
        out = place / "out"
        workers = 2 if rng.random() < 0.25 else 1
        for _ in range(min(in_a_row, kills - counted["killed"])):
            fresh = not _finished(out)
            counted.update(_kill_once(library, out, workers, rng.uniform(0, life if fresh else 0.6 * life)))
        if _Run(library, out, workers).wait() != 0:
            counted["FAULT: the last run failed"] += 1
        if hashes(out) != expected:
            counted["FAULT: other bytes"] += 1
        counted["finished and compared"] += 1
        shutil.rmtree(out)
        print(f"{counted['killed']} kills: {dict(counted)}", flush=True)
    return counted


def hashes(out: Path) -> dict[str, str]:
    """SHA-256 of every result file of a run."""
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.name not in UNLIKE
    }


def _kill_once(library: Path, out: Path, workers: int, after_s: float) -> Iterator[str]:
    """Start or resume a run and kill it after a while; yields what happened."""
    before = _finished(out)
    run = _Run(library, out, workers)
    if run.wait(after_s) is None:
        run.kill()
        yield "killed"
    else:
        yield "ended before the kill"
    after = _finished(out)
    yield f"killed with {len(after)} of {len(CLIPS)} clips finished"
    if before.items() - after.items():
        yield "FAULT: a finished clip was lost or done again"


def _finished(out: Path) -> dict[Path, int]:
    """The records of finished clips and when they were written."""
    return {path: path.stat().st_mtime_ns for path in out.glob(".w2w/clips/*.json")}


class _Run:
    """`w2w run` in a process and a session of its own, forked here so that nothing is imported 400 times."""

    def __init__(self, library: Path, out: Path, workers: int) -> None:
        options = ["--patches", "8", "--workers", str(workers), "--no-pictures"]
        self.pid = os.fork()
        if self.pid == 0:
            os.setsid()
            with Path(os.devnull).open("r+b") as nowhere:
                for stream in range(3):
                    os.dup2(nowhere.fileno(), stream)
            code = 1
            try:
                main_command(["run", str(library), "--out", str(out), *options])
            except SystemExit as end:
                code = end.code if isinstance(end.code, int) else int(end.code is not None)
            finally:
                os._exit(code)

    def wait(self, seconds: float = 600.0) -> int | None:
        """Its exit code, or None where it is still at work after so long."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                return os.waitstatus_to_exitcode(status)
            time.sleep(0.005)
        return None

    def kill(self) -> None:
        """End it and its workers at once."""
        os.killpg(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)


if __name__ == "__main__":
    main()
