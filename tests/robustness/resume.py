# SPDX-License-Identifier: GPL-3.0-or-later
"""Kill a run at random moments and let the same command go on: are the bytes those of an undisturbed run?

    python -m tests.robustness.resume [--kills 200] [--in-a-row 4] [--seed 0] [--json OUT.json]

`w2w run` on ten short real clips is killed with all its workers (SIGKILL, which nothing can catch); what goes
on from there is killed again, up to so many times in a row, and then left to finish. Half of the kills wait
until a drawn number of clips is finished, and then a random part of half the time that a clip takes; a
quarter wait for a step after the clips (ranking, choosing, testing together, writing), and then a random part
of the time that it takes; a quarter fall at any time between start and end. Printed are the kills, how many
clips were finished at each and at which step it fell, and how often bytes differed, half-written files stayed
behind or a finished clip was done again: 0, or it is a fault.
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
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from w2w.core.files import write_json
from w2w.headless.app import main as main_command
from w2w.headless.runs.monitor import read_state
from w2w.headless.runs.records import read_records

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data" / "mixamo"
CLIPS = {
    "Conqster__TheBarMan/Walking.fbx": "walking",
    "M3-org__CharacterStudio/StrutWalking.fbx": "walking",
    "guysitstom__Second-Animation/Sneak Walk.fbx": "walking",
    "murpysn__CobaPlayground/aj@Walking.fbx": "walking",
    "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Run.fbx": "running",
    "kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx": "running",
    "M3-org__CharacterStudio/Running.fbx": "running",
    "GDDMN__Test_DigitalOxygen/Roundhouse Kick.fbx": "kicking",
    "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Mma Kick.fbx": "kicking",
    "kirbycope__godot-4.3-sandbox-3d/Kicking_Left.fbx": "kicking",
}
BAKING = "turning motions to signals"
AFTERWARDS = (
    "ranking patches",
    "choosing sensors to wear together",
    "writing results",
)
"""Steps of a run, as it writes them down for `w2w status`."""

KINDS = {"clips": 0.5, "afterwards": 0.25, "anywhere": 0.25}
UNLIKE = ("state.json", "current.json", "holder", "lock", "records.jsonl")
"""Files that tell of the run itself, or when it was."""

POLL_S = 0.002


@dataclass(frozen=True)
class Pace:
    """How long an undisturbed run took.

    Parameters
    ----------
    life : float
        Seconds from start to end.
    clip : float
        Seconds a clip, with one worker.
    steps : dict of str to float
        Seconds of each step.
    """

    life: float
    clip: float
    steps: dict[str, float]


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
    for name, count in sorted(found.items()):
        print(f"{count:5d}  {name}")
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
    pace = _undisturbed(library, place / "undisturbed")
    expected = hashes(place / "undisturbed")
    counted: Counter[str] = Counter()
    out = place / "out"
    while counted["killed"] < kills:
        workers = 2 if rng.random() < 0.2 else 1
        for _ in range(min(in_a_row, kills - counted["killed"])):
            counted.update(_kill_once(library, out, workers, pace, rng))
        before = finished_clips(out)
        if _Run(library, out, workers).wait() != 0:
            counted["FAULT: the last run failed"] += 1
        if before.items() - finished_clips(out).items():
            counted["FAULT: the last run did a finished clip again"] += 1
        for name, _ in sorted(hashes(out).items() ^ expected.items()):
            counted[f"FAULT: not as undisturbed: {name}"] += 1
        counted["finished and compared"] += 1
        shutil.rmtree(out)
        print(f"{counted['killed']} kills, {counted['finished and compared']} compared", flush=True)
    return counted


def hashes(out: Path) -> dict[str, str]:
    """SHA-256 of every result file of a run."""
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.name not in UNLIKE
    }


def finished_clips(out: Path) -> dict[str, int]:
    """The finished clips and when their records were written."""
    return {clip: record["at"] for clip, record in read_records(out).items()}


def _undisturbed(library: Path, out: Path) -> Pace:
    """Run to the end with one worker, and see how long everything takes."""
    began: dict[str, float] = {}
    start = time.monotonic()
    run = _Run(library, out, 1)
    while run.wait(POLL_S) is None:
        began.setdefault(_step(out), time.monotonic())
    end = time.monotonic()
    written = sorted(finished_clips(out).values())
    if len(written) < len(CLIPS):
        raise SystemExit("the undisturbed run did not finish all clips")
    ends = [*list(began.values())[1:], end]
    steps = {step: after - before for (step, before), after in zip(began.items(), ends, strict=True)}
    return Pace(end - start, (written[-1] - written[0]) / 1e9 / (len(written) - 1), steps)


def _step(out: Path) -> str:
    """What the run in a folder is doing."""
    try:
        return read_state(out).step
    except (OSError, ValueError):
        return "starting"


def _kill_once(library: Path, out: Path, workers: int, pace: Pace, rng: np.random.Generator) -> list[str]:
    """Start or resume a run and kill it at a drawn moment; what happened."""
    before = finished_clips(out)
    kind = rng.choice(list(KINDS), p=list(KINDS.values()))
    if kind == "clips" and len(before) < len(CLIPS) - 1:
        wanted = rng.integers(len(before) + 1, len(CLIPS))
        seconds = rng.uniform(0, pace.clip / 2)

        def reached() -> bool:
            return len(finished_clips(out)) >= wanted
    elif kind == "anywhere":
        seconds = rng.uniform(0, pace.life)

        def reached() -> bool:
            return True
    else:
        step = rng.choice(AFTERWARDS)
        seconds = rng.uniform(0, pace.steps.get(step, 0.0))

        def reached() -> bool:
            return _step(out) == step

    run = _Run(library, out, workers)
    ended = run.wait_until(reached) is not None or run.wait(seconds) is not None
    if ended:
        return ["ended before the kill"]
    run.kill()
    after = finished_clips(out)
    said = [
        "killed",
        f"killed with {len(after):2d} of {len(CLIPS)} clips finished",
        f"killed at: {_step(out)}",
    ]
    if before.items() - after.items():
        said.append("FAULT: a finished clip was lost or done again")
    return said


class _Run:
    """`w2w run` in a process and a session of its own, forked here so that nothing is imported 400 times."""

    def __init__(self, library: Path, out: Path, workers: int) -> None:
        (out / ".w2w" / "state.json").unlink(
            missing_ok=True
        )  # of the run before, whose step is not this one's
        options = ["--patches", "4", "--workers", str(workers), "--no-pictures"]
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
        return self.wait_until(lambda: time.monotonic() >= until)

    def wait_until(self, reached: Callable[[], bool]) -> int | None:
        """Its exit code, or None where it is still at work when something is reached."""
        while not reached():
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                return os.waitstatus_to_exitcode(status)
            time.sleep(POLL_S)
        return None

    def kill(self) -> None:
        """End it and its workers at once."""
        os.killpg(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)


if __name__ == "__main__":
    main()
