# SPDX-License-Identifier: GPL-3.0-or-later
"""A clock that is set, a slow folder, a very long clip, a disk that fills late: no wrong blame, no loss."""

import errno
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from filelock import FileLock
from rich.console import Console
from typer.testing import CliRunner

from w2w.core.files import write_npz
from w2w.core.library.library import Clip, Library
from w2w.core.reading import guard as worker_guard
from w2w.core.reading.guard import guarded, timed_out
from w2w.core.study.config import StudyConfig
from w2w.core.study.results import ClipResult
from w2w.core.study.signals import place_patches
from w2w.headless import app
from w2w.headless.app import APP
from w2w.headless.commands import execute
from w2w.headless.commands.status import describe
from w2w.headless.console import sentence_of
from w2w.headless.runs import clip as clip_work, clip_task, monitor as watch, records
from w2w.headless.runs.clip import WORK, do_clip, record_death
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.folder import HOLDER, make_folders
from w2w.headless.runs.monitor import RunMonitor, read_state
from w2w.headless.runs.records import read_records

from ..command_line import cli
from ..robustness.resume import hashes
from .kept_clips import done

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

ROOT = Path(__file__).resolve().parents[2]


def moving(path, frames=90, seed=0, scale=0.2):
    rng = np.random.default_rng(seed)
    seconds = np.arange(frames)[:, None] / 30
    poses = scale * np.sin(2 * np.pi * seconds * rng.uniform(0.5, 2, 72) + rng.uniform(0, 6, 72))
    poses[:, 0] += np.pi / 2  # z up
    path.parent.mkdir(parents=True, exist_ok=True)
    write_npz(path, {"poses": poses, "trans": np.zeros((frames, 3)), "mocap_framerate": np.array(30.0)})


@pytest.fixture
def task(bundled_body, tmp_path):
    """A clip of three seconds, to be worked on at four places."""
    config, out = StudyConfig(patches=4), tmp_path / "out"
    make_folders(out)
    bundled_body.save(out / WORK / "body.npz")
    place_patches(bundled_body, config).save(out / WORK / "patches.npz")
    moving(tmp_path / "clip.npz")
    return ClipTask(Clip(tmp_path / "clip.npz", "clip.npz", "clip", "moving"), out, config, "inputs")


def test_a_clock_that_is_set_back_changes_no_duration(tmp_path, monkeypatch):
    make_folders(tmp_path)
    ran, now = [0.0], [1e9]
    monkeypatch.setattr(watch.time, "monotonic", lambda: ran[0])
    monkeypatch.setattr(watch.time, "time", lambda: now[0])
    clip = Clip(Path("a.npz"), "a.npz", "a", "moving")
    seen = RunMonitor(Console(quiet=True))
    seen.begin(Library(tmp_path, (clip, clip), "folder names"), "neutral", tmp_path)
    seen.announce("turning motions to signals")
    ran[0], now[0] = 60.0, 1e9 - 3600  # set back by an hour
    seen.clip_done(ClipResult(clip, "", {}, ""))
    state = read_state(tmp_path)
    assert state.done == 1  # written, though the clock says that it was just written
    assert "Running for 1 min 00 s" in describe(state, True)
    assert "About 1 min 00 s of clips left" in describe(state, True)
    assert "Stopped after 1 min 00 s" in describe(state, False)


@pytest.mark.parametrize("held", [False, True])
def test_a_run_is_watched_where_nothing_can_be_written(tmp_path, monkeypatch, held):
    def cannot(lock, **_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), lock.lock_file)

    make_folders(tmp_path)
    seen = RunMonitor(Console(quiet=True))
    seen.begin(Library(tmp_path, (), "folder names"), "neutral", tmp_path)
    seen.announce("turning motions to signals")
    if held:
        (tmp_path / WORK / HOLDER).write_text("process 1 on another machine\n")
    monkeypatch.setattr(FileLock, "acquire", cannot)
    code, said = cli("status", tmp_path)
    assert code == 0, said
    assert said.strip().startswith("Running for" if held else "Stopped after")


def test_what_no_command_foresaw_of_a_disk_is_a_sentence(monkeypatch, capsys):
    def full(**_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), "there/tables.csv")

    monkeypatch.setattr(app, "APP", full)
    monkeypatch.setattr(app, "use_own_temporary_folder", lambda: None)
    with pytest.raises(SystemExit) as ended:
        app.main(["tables"])
    assert ended.value.code == 1
    assert capsys.readouterr().err == "No result: there/tables.csv cannot be opened: Read-only file system\n"


@pytest.mark.parametrize("hours", [-2, 2])
def test_a_death_is_told_from_a_timeout_whatever_the_clock_says(task, monkeypatch, hours):
    task.marker.write_text("")
    monkeypatch.setattr(time, "time", lambda: 1e9 + 3600 * hours)
    assert "the program that reads it crashed" in record_death(task)["reason"]
    task.marker.write_text(f"{64 * '0'}\nTimeout (0:05:00)!\nThread 0x7f (most recent call first):\n")
    assert "longer than the limit of 300 s" in record_death(task)["reason"]


GUARDED = """
import sys, time
from pathlib import Path
from w2w.core.reading.guard import guarded, untimed
with guarded(0.5, marker=Path(sys.argv[1])):
    if sys.argv[2] == "slow folder":
        with untimed():
            time.sleep(0.8)
    elif sys.argv[2] == "slow clip":
        time.sleep(30)
    elif sys.argv[2] == "both":
        with untimed():
            time.sleep(0.8)
        time.sleep(30)
"""


@pytest.mark.parametrize(("case", "survives"), [("slow folder", True), ("slow clip", False), ("both", False)])
def test_only_the_clips_own_time_is_limited(tmp_path, case, survives):
    done = subprocess.run([sys.executable, "-c", GUARDED, tmp_path / "said", case], cwd=ROOT, check=False)
    assert (done.returncode == 0) is survives
    assert timed_out(tmp_path / "said") is not survives


def test_writing_a_clips_results_is_not_its_own_time(task, monkeypatch):
    slow = []

    def watched(name, work):
        def slowly(*arguments, **options):
            slow.append((name, running[-1]))
            return work(*arguments, **options)

        return slowly

    running = [False]
    for name, state in (("start", True), ("pause", False)):
        method = getattr(worker_guard._Watchdog, name)
        monkeypatch.setattr(
            worker_guard._Watchdog,
            name,
            lambda self, method=method, state=state: (running.append(state), method(self))[1],
        )
    for module, name in (
        (clip_work, "file_sha256"),
        (clip_task, "file_sha256"),
        (clip_work, "write_features"),
        (records, "file_sha256"),
        (clip_work, "load_clip"),
        (clip_work, "describe"),
    ):
        monkeypatch.setattr(module, name, watched(name, getattr(module, name)))
    with guarded(600):
        assert not do_clip(task)["reason"]
    assert {name for name, timed in slow if timed} == {
        "load_clip",
        "describe",
        "file_sha256",
    }  # the clip's own
    assert {name for name, timed in slow if not timed} == {"file_sha256", "write_features"}


@pytest.mark.slow
def test_a_motion_of_200_000_frames_is_refused_before_its_signals_are_made(task, tmp_path):
    moving(tmp_path / "clip.npz", frames=200_000)
    config = StudyConfig(patches=512)
    result = do_clip(ClipTask(task.clip, task.out, config, "inputs"))
    assert result["reason"] == (
        "it lasts 111 minutes, and its signals at 512 patches would take 3.8 GiB: cut it into parts of at "
        "most 29 minutes, or raise --clip-memory"
    )
    assert not list((task.out / "signals").iterdir())


def run(library, out):
    return cli("run", library, "--out", out, "--patches", 4, "--workers", 1, "--no-pictures")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system limits no file sizes")
@pytest.mark.parametrize("stage", ["ranking patches", "the report"])
def test_a_disk_that_is_full_after_the_clips_loses_nothing(tmp_path, monkeypatch, stage):
    import resource

    for number, (activity, scale) in enumerate(
        [("calm", 0.05), ("calm", 0.06), ("wild", 0.3), ("wild", 0.4)]
    ):
        moving(tmp_path / "library" / activity / f"{number}.npz", seed=number, scale=scale)
    library, out = tmp_path / "library", tmp_path / "out"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1, before[1]))

    announce, results = RunMonitor.announce, execute.write_results

    def next_step(self, name, message=""):
        announce(self, name, message)
        if name == stage:
            fill()

    def then_full(study):
        results(study)
        if stage == "the report":
            fill()

    with monkeypatch.context() as patched:
        patched.setattr(RunMonitor, "announce", next_step)
        patched.setattr(execute, "write_results", then_full)
        try:
            code, said = run(library, out)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert code == 1
    assert f"{out} cannot be written" in said
    assert "What is finished is kept" in said
    assert not list(out.rglob("*.part"))
    assert not (out / "report.html").exists()
    assert (out / "utility.csv").exists() is (stage == "the report")
    kept = {path: path.stat().st_mtime_ns for path in (out / "signals").iterdir()}
    assert len(kept) == 4
    assert run(library, out)[0] == 0
    assert {path: path.stat().st_mtime_ns for path in (out / "signals").iterdir()} == kept
    assert run(library, tmp_path / "undisturbed")[0] == 0
    assert hashes(out) == hashes(tmp_path / "undisturbed")


def test_a_run_that_finds_too_little_memory_says_so_and_keeps_it(motions, tmp_path, monkeypatch):
    def too_much(*_):
        raise MemoryError("Unable to allocate 1.26 MiB")

    monkeypatch.setattr(execute, "make_signals", too_much)
    done = CliRunner().invoke(APP, ["run", str(motions), "--out", str(tmp_path / "out")])
    assert done.exit_code == 1
    sentence = sentence_of(MemoryError("Unable to allocate 1.26 MiB"))
    assert f"No result: {sentence}" in " ".join(done.output.split())
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["problem"] == sentence


@pytest.mark.parametrize("failure", [MemoryError(), ImportError("failed to map segment")])
def test_a_clip_is_not_given_up_for_a_limit_that_is_not_w2ws(task, monkeypatch, failure):
    def fails(_):
        raise failure

    monkeypatch.setattr(clip_work, "_make", fails)
    monkeypatch.setattr(clip_work, "allowed_memory", lambda: 2.0**30)
    result = done(task)
    assert result.reason == "it takes more than the 1.0 GiB of memory that W2W may use here (ulimit)"
    task.marker.write_text("")
    assert record_death(task)["reason"] == result.reason
    assert not read_records(task.out)
    monkeypatch.setattr(clip_work, "allowed_memory", lambda: float("inf"))
    assert "it needs more than 4 GiB" in done(task).reason or isinstance(failure, ImportError)
    assert list(read_records(task.out)) == [task.clip.name]


@pytest.mark.later
def test_no_command_waits_for_libraries_that_few_need():
    """Matplotlib takes a third of a second, and fails where a notebook's backend is not installed."""
    code = "import sys, w2w.headless.app; print(*{'matplotlib', 'torch', 'sklearn', 'PIL'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
