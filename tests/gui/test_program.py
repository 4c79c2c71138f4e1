# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line inside a real Blender program that has nothing but the extension's zip.

Needs the folder that `tools/real_blender.sh` sets up, a zip in dist/ that `tools/build_extension.py` made,
and the real clips; skips where one is missing.
"""

from __future__ import annotations

import csv
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from w2w.core.imu.presets import DEFAULT_SENSOR, preset
from w2w.core.imu.recording import ImuRecording
from w2w.headless.runs.records import read_records

from ..sensor_steps import assert_same_to_one_step
from .sandbox import PROJECT, RESULTS, inside, newest_zip

PLACE = RESULTS / f"program{os.environ.get('PYTEST_XDIST_WORKER', '')}"
"""A folder that the sandbox sees; one of its own for each process that runs tests."""

CLIPS = {
    "walking/good 1.fbx": "Conqster__TheBarMan/Walking.fbx",
    "walking/good 2.fbx": "M3-org__CharacterStudio/StrutWalking.fbx",
    "running/good 1.fbx": "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Run.fbx",
    "running/good 2.fbx": "kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx",
}
STUDY = ("--patches", "32", "--workers", "2")
RADIANS_OR_METRES = 1e-5
"""How far motions may differ between two Blenders, whose importers and numpy differ."""

TIMEOUT_S = 1800
"""A busy machine is slow; the longest takes a minute on an idle one."""

pytestmark = pytest.mark.slow


def blender(*arguments: str, resources: str = "installed") -> list[str]:
    """The command that runs the sandbox's Blender, with the extension or without."""
    variable = f"BLENDER_USER_RESOURCES={inside(PLACE / resources)}"
    return [str(PROJECT / "tools" / "real_blender.sh"), "run", variable, "blender", *arguments]


def done(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run to the end; no traceback may ever show."""
    ended = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert "Traceback" not in ended.stdout + ended.stderr, ended.stdout + ended.stderr
    return ended


def hashes(out: Path) -> dict[str, str]:
    """SHA-256 of every result that is the same for the same input."""
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.suffix in (".csv", ".json", ".npz") and path.name not in ("state.json", "current.json")
    }


@pytest.fixture(scope="module")
def library(shared_data: Path) -> Path:
    """Four real clips and two bad files; the extension is installed from its zip beside it."""
    extension = newest_zip()
    shutil.rmtree(PLACE, ignore_errors=True)
    for folder in ("installed", "bare", "library/walking", "library/running"):
        (PLACE / folder).mkdir(parents=True)
    for name, file in CLIPS.items():
        shutil.copy(shared_data / "mixamo" / file, PLACE / "library" / name)
    (PLACE / "library" / "running" / "empty.fbx").touch()
    whole = (PLACE / "library" / "walking" / "good 2.fbx").read_bytes()
    (PLACE / "library" / "walking" / "cut.fbx").write_bytes(whole[: len(whole) // 2])
    install = ["--command", "extension", "install-file", "--repo", "user_default", "--enable"]
    installed = done(blender(*install, inside(extension)))
    assert installed.returncode == 0, installed.stdout + installed.stderr
    return PLACE / "library"


@pytest.fixture(scope="module")
def study(library: Path) -> tuple[subprocess.CompletedProcess[str], Path]:
    """A run by the extension's command, with all its pictures, and its results."""
    out = PLACE / "by command"
    return done(
        blender("--command", "w2w", "run", inside(library), "--out", inside(out), *STUDY, "--strict")
    ), out


def test_the_installed_zip_alone_runs_a_whole_study(study) -> None:
    ended, out = study
    assert ended.returncode == 3, ended.stdout + ended.stderr  # --strict, and two files are bad
    clips = [json.loads(line) for line in (out / "clips.jsonl").read_text().splitlines()]
    skipped = [entry["file"] for entry in clips if "skipped" in entry]
    assert skipped == ["running/empty.fbx", "walking/cut.fbx"]
    drawn = {path.name for path in (out / "heatmaps").iterdir()}
    assert drawn == {"running.png", "walking.png", "mean.png", "subset.png"}
    assert (out / "report.html").stat().st_size > 100_000
    assert (out / "study.blend").stat().st_size > 100_000


def test_it_agrees_with_the_blender_module(study, library: Path) -> None:
    out, theirs = PLACE / "by module", study[1]
    command = [sys.executable, "-m", "headless", "run", str(library), "--out", str(out), *STUDY]
    assert done([*command, "--no-pictures", "--no-report"]).returncode == 0
    for path in sorted(out.glob("motions/*.npz")):
        ours, other = np.load(path), np.load(theirs / "motions" / path.name)
        for name in ("poses", "trans"):
            np.testing.assert_allclose(ours[name], other[name], rtol=0, atol=RADIANS_OR_METRES)
    for path in sorted(out.glob("signals/*.npz")):
        ours, other = (ImuRecording.load(folder / "signals" / path.name) for folder in (out, theirs))
        assert_same_to_one_step(ours, other, preset(DEFAULT_SENSOR), seldom=1.0)
    tables = [list(csv.reader((folder / "utility.csv").open())) for folder in (out, theirs)]
    assert [row[:3] for row in tables[0]] == [row[:3] for row in tables[1]]


def test_a_script_by_its_path_takes_the_extensions_libraries(study, library: Path) -> None:
    out = PLACE / "by path"
    script = ["--background", "--factory-startup", "--python", "/project/headless/run.py", "--"]
    ended = done(blender(*script, inside(library), "--out", inside(out), *STUDY, "--no-pictures"))
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert hashes(out) == hashes(study[1])


def test_the_other_commands_and_their_exit_codes(study, library: Path) -> None:
    ended = done(blender("--command", "w2w", "status", inside(study[1])))
    assert (ended.returncode, "6 of 6 clips done, 2 of them skipped" in ended.stdout) == (0, True)
    assert done(blender("--command", "w2w", "status", inside(PLACE))).returncode == 2
    assert done(blender("--command", "w2w", "report", inside(study[1]))).returncode == 0
    sweep = done(blender("--command", "w2w", "sweep", inside(study[1]), "--out", inside(PLACE / "sweep")))
    assert (sweep.returncode, "W2W's studies are a package of their own" in sweep.stderr) == (2, True)
    ended = done(blender("--command", "w2w", "inspect", inside(library / "walking" / "good 1.fbx")))
    assert (ended.returncode, "would be used" in ended.stdout) == (0, True)


def blenders(process: subprocess.Popen) -> list[psutil.Process]:
    """The Blender that a command started, and its workers."""
    tree = psutil.Process(process.pid).children(recursive=True)
    return sorted((found for found in tree if found.name() == "blender"), key=lambda found: found.pid)


def disturbed(command: list[str], out: Path, signal_number: int) -> int:
    """Send a signal to a run as it works on clips; its exit code, once its workers are gone too."""

    def records() -> set[str]:
        return set(read_records(out))

    before = records()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while records() <= before:  # the run itself first moves an earlier one's records away
        assert process.poll() is None
        time.sleep(0.05)
    main, *workers = blenders(process)
    assert workers
    main.send_signal(signal_number)
    code = process.wait(timeout=TIMEOUT_S)
    assert not psutil.wait_procs(workers, timeout=60)[1]
    return code


def test_stopped_and_killed_runs_go_on_and_end_with_the_same_bytes(study, library: Path) -> None:
    out = PLACE / "disturbed"
    command = blender("--command", "w2w", "run", inside(library), "--out", inside(out), *STUDY)
    command += ["--no-pictures"]
    assert disturbed(command, out, signal.SIGINT) == 130
    assert disturbed(command, out, signal.SIGKILL) != 0
    assert done(command).returncode == 0
    assert hashes(out) == hashes(study[1])


def test_clips_that_crash_hang_or_fill_a_worker_cost_only_themselves(library: Path) -> None:
    report = PLACE / "bad_tasks.json"
    paths = [inside(path) for path in (library, PLACE / "bad tasks", report)]
    script = ["--background", "--python-exit-code", "1", "--python", "/project/tests/gui/bad_tasks.py", "--"]
    ended = done(blender(*script, *paths))
    assert ended.returncode == 0, ended.stdout + ended.stderr
    found = json.loads(report.read_text())
    crashed, hung, filled, good = found["reasons"]
    assert "the program that reads it crashed" in crashed
    assert "longer than the limit of 10 s" in hung
    assert "more than 2 GiB of memory" in filled
    assert good == ""
    assert found["told"] == 4
    assert found["alone"] == [None, True]
    assert found["markers"] == []


def test_libraries_can_be_made_for_a_blender_without_the_extension(library: Path) -> None:
    program = "tools/sandboxed_blender.sh"
    subprocess.run(["make", "setup", f"BLENDER={program}"], cwd=PROJECT, check=True, timeout=TIMEOUT_S)
    script = ["--background", "--python", "/project/headless/w2w.py", "--", "inspect"]
    ended = done(blender(*script, inside(library / "running" / "good 1.fbx"), resources="bare"))
    assert (ended.returncode, "would be used" in ended.stdout) == (0, True), ended.stderr
