# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C, SIGTERM and SIGHUP at every stage of a run: a sentence, its exit code, nobody left at work."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from w2w.headless.runs.folder import FolderBusyError, only_run
from w2w.headless.runs.monitor import read_state

from ..patience import HANG_S
from ..real_clips import in_folders

if not sys.platform.startswith("linux"):
    pytest.skip("it looks into /proc", allow_module_level=True)

ROOT = Path(__file__).resolve().parents[2]
SENTENCE = "Stopped. What is finished is kept: the same command goes on from here."
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}


@pytest.fixture(scope="module")
def library(shared_data, tmp_path_factory):
    return in_folders(shared_data, tmp_path_factory.mktemp("library"))


@pytest.fixture
def temporary(tmp_path):
    """The run's temporary folder, empty at first."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    return folder


@pytest.fixture
def start(library, tmp_path, temporary):
    """Start a run in a session of its own, as a terminal does."""
    begun = []

    def start(*options, patches=16):
        process = subprocess.Popen(
            [sys.executable, "-m", "headless", "run", library, "--out", tmp_path / "out",
             "--patches", str(patches), "--workers", "2", *options],
            cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
            env=os.environ | {"TMPDIR": str(temporary)}, preexec_fn=hear_signals,
        )  # fmt: skip
        begun.append(process)
        return process

    yield start
    for process in begun:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def hear_signals():
    """A background job, as these tests may be, is started deaf to some."""
    for number in CODES:
        signal.signal(number, signal.SIG_DFL)


def members(session):
    """Processes of a session that are not dead."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = stat.read_text().rpartition(")")
        except OSError:
            continue
        state, _, _, its_session = rest.split()[:4]
        if int(its_session) == session and state not in "ZX":
            found.append(int(name.split()[0]))
    return found


def until(reached, process, seconds=HANG_S):
    """Wait until something is so while a process lives."""
    end = time.monotonic() + seconds
    while not reached():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.005)


def hears(process, number):
    """Whether a process has a handler for a signal."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = int(next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt")), 16)
    return bool(caught >> (number - 1) & 1)


def deaf(process, number):
    """Whether a process blocks or ignores a signal."""
    status = dict(
        line.split(":", 1) for line in Path(f"/proc/{process}/status").read_text().splitlines() if ":" in line
    )
    unheard = int(status["SigBlk"], 16) | int(status["SigIgn"], 16)
    return bool(unheard >> (number - 1) & 1)


def step(out):
    try:
        return read_state(out).step
    except (OSError, ValueError):
        return ""


def stopped(process, number, out, to_all=False):
    """Send a signal and see that all ends as it shall; what was said."""
    (os.killpg if to_all else os.kill)(process.pid, number)
    said, errors = process.communicate(timeout=HANG_S)
    assert process.returncode == CODES[number], (said, errors)
    assert "Traceback" not in said + errors
    assert not errors, errors
    workers = [member for member in members(process.pid) if "-m" in arguments(member)]
    assert not workers
    if out.exists():
        with only_run(out / ".w2w"):  # the lock is free
            pass
    return said


def arguments(process):
    try:
        return Path(f"/proc/{process}/cmdline").read_text().split("\0")
    except OSError:
        return []


def assert_no_child_hears_ctrl_c(process):
    """A terminal sends it to all, twice where it is pressed twice: the run alone answers."""
    children = [member for member in members(process.pid) if member != process.pid]
    assert len(children) >= 4  # two workers, two trackers of semaphores
    assert [arguments(child) for child in children if not deaf(child, signal.SIGINT)] == []
    trackers = [child for child in children if "resource_tracker" in str(arguments(child))]
    assert len(trackers) == 2
    assert all(deaf(child, signal.SIGHUP) for child in trackers)


def stages(out):
    return {
        "imports": lambda process: hears(process, signal.SIGTERM),
        "patches": lambda _: step(out) == "placing patches",
        "workers": lambda _: len(list(out.glob(".w2w/running/*"))) > 0,
        "ranking": lambda _: step(out) == "ranking patches",
        "pictures": lambda _: (out / "heatmaps").is_dir(),
        "report": lambda _: list(out.glob(".report.html.*")),
    }


def nothing_is_left(temporary):
    return not list(temporary.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stage", "number", "to_all"),
    [
        ("imports", signal.SIGINT, True),
        ("patches", signal.SIGTERM, False),
        ("ranking", signal.SIGHUP, False),
        ("pictures", signal.SIGINT, True),
    ],
)
def test_a_signal_ends_a_run(start, tmp_path, temporary, stage, number, to_all):
    out = tmp_path / "out"
    process = start(patches=512 if stage == "patches" else 16)
    until(lambda: stages(out)[stage](process), process)
    assert SENTENCE in stopped(process, number, out, to_all)
    assert nothing_is_left(temporary)


@pytest.mark.slow
def test_a_signal_ends_the_workers_too_and_the_next_run_goes_on(start, tmp_path, temporary):
    out = tmp_path / "out"
    for number, to_all in ((signal.SIGTERM, False), (signal.SIGHUP, True), (signal.SIGINT, True)):
        for marker in out.glob(".w2w/running/*"):  # of the run before
            marker.unlink()
        process = start("--no-pictures", "--no-report")
        until(lambda: list(out.glob(".w2w/running/*")), process)
        assert_no_child_hears_ctrl_c(process)
        assert SENTENCE in stopped(process, number, out, to_all)  # to all, as a terminal sends it
        assert nothing_is_left(temporary)
    assert start("--no-pictures", "--no-report").wait() == 0


@pytest.mark.slow
def test_machines_are_told_in_one_line(start, tmp_path):
    process = start("--log-json", "--no-pictures")
    out = tmp_path / "out"
    until(lambda: list(out.glob(".w2w/running/*")), process)
    os.killpg(process.pid, signal.SIGINT)
    os.killpg(process.pid, signal.SIGINT)  # who presses it twice
    events = [json.loads(line) for line in stopped(process, signal.SIGINT, out, True).splitlines()]
    assert [event["event"] for event in events].count("finished") == 1
    assert events[-1]["exit_code"] == 130
    assert events[-1]["problem"] == SENTENCE


@pytest.mark.slow
def test_a_run_that_is_told_to_survive_the_terminal_does(motions, tmp_path):
    process = subprocess.Popen(
        ["nohup", sys.executable, "-m", "headless", "run", motions, "--out", tmp_path / "out",
         "--patches", "16", "--no-pictures", "--no-report"],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True,
    )  # fmt: skip
    until(lambda: hears(process, signal.SIGTERM), process)
    process.send_signal(signal.SIGHUP)
    assert "8 of 8 clips ranked" in " ".join(process.communicate(timeout=HANG_S)[0].split())
    assert process.returncode == 0


@pytest.mark.slow
def test_workers_end_with_a_run_that_is_killed_and_the_next_one_cleans_up(start, tmp_path, temporary):
    process = start("--no-pictures", "--no-report")
    out = tmp_path / "out"
    until(lambda: list(out.glob(".w2w/running/*")), process)
    assert list(temporary.glob("w2w-run-*"))
    process.kill()
    process.wait()
    end = time.monotonic() + HANG_S
    while members(process.pid) and time.monotonic() < end:
        time.sleep(0.05)
    assert not [arguments(member) for member in members(process.pid)]
    assert list(temporary.glob("w2w-run-*"))
    again = start("--no-pictures", "--no-report")
    assert again.wait() == 0, again.communicate()
    assert nothing_is_left(temporary)


@pytest.mark.slow
def test_the_folder_of_a_run_that_lives_is_left_alone(start, tmp_path, temporary):
    process = start("--no-pictures", "--no-report")
    out = tmp_path / "out"
    until(lambda: list(out.glob(".w2w/running/*")), process)
    process.send_signal(signal.SIGSTOP)  # so that it cannot end before the second one has looked
    mine = set(temporary.glob("w2w-run-*"))
    assert mine
    with pytest.raises(FolderBusyError), only_run(out / ".w2w"):
        pass
    second = start("--no-pictures", "--no-report")
    assert second.wait() == 4
    assert mine <= set(temporary.glob("w2w-run-*"))
    process.send_signal(signal.SIGCONT)
    assert process.wait() == 0, process.communicate()
