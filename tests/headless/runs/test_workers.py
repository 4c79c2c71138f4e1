# SPDX-License-Identifier: GPL-3.0-or-later
"""Workers that die or hang cost at most the clip they were at; a cluster gives the same bytes."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cloudpickle
import pytest

from w2w.headless.runs import workers
from w2w.headless.runs.clip import WORK
from w2w.headless.runs.clip_task import ClipTask, Engine
from w2w.headless.runs.records import read_records
from w2w.headless.runs.workers import Crew, run_tasks

from ...patience import HANG_S
from ..kept_clips import run_all

ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class CrashingTask(ClipTask):
    """A task whose file makes a worker segfault, wherever it is done but in the test itself."""

    safe_process: int = 0

    def key(self, source_sha256):
        if os.getpid() != self.safe_process:
            os.kill(os.getpid(), signal.SIGSEGV)
        return super().key(source_sha256)


@dataclass(frozen=True)
class HangingTask(ClipTask):
    """A task whose file makes a worker wait for ever."""

    safe_process: int = 0

    def key(self, source_sha256):
        if os.getpid() != self.safe_process:
            time.sleep(600)
        return super().key(source_sha256)


cloudpickle.register_pickle_by_value(sys.modules[CrashingTask.__module__])


@pytest.mark.slow
def test_a_clip_that_crashes_its_worker_is_skipped_and_the_others_are_used(tasks):
    bad = CrashingTask(tasks[1].clip, tasks[1].out, tasks[1].config, "inputs", safe_process=os.getpid())
    results = run_all([tasks[0], bad, *tasks[2:]], 2)
    assert [result.used for result in results] == [True, False, True, True]
    assert "crashed" in results[1].reason
    assert read_records(bad.out)[bad.clip.name]["reason"] == results[1].reason  # for later runs


@dataclass(frozen=True)
class KilledTask(ClipTask):
    """A task at which a worker is killed from outside, as by a system short of memory, so many times."""

    safe_process: int = 0
    kills: int = 0

    def key(self, source_sha256):
        log = self.out / "kills"
        if os.getpid() != self.safe_process and (not log.exists() or len(log.read_text()) < self.kills):
            with log.open("a") as stream:
                stream.write("x")
            os.kill(os.getpid(), signal.SIGKILL)
        return super().key(source_sha256)


@pytest.mark.slow
@pytest.mark.parametrize(("kills", "reason"), [(3, ""), (99, "not done yet")])
def test_a_clip_whose_worker_is_killed_from_outside_is_never_blamed(tasks, kills, reason):
    first = tasks[1]
    bad = KilledTask(first.clip, first.out, first.config, "inputs", safe_process=os.getpid(), kills=kills)
    result = run_all([bad], 1)[0]
    assert result.reason.startswith(reason)
    assert result.used is not bool(reason)
    assert (bad.clip.name in read_records(bad.out)) is result.used
    assert not bad.marker.exists()


@pytest.mark.slow
def test_workers_that_were_ready_and_died_are_replaced(tasks):
    bad = CrashingTask(tasks[1].clip, tasks[1].out, tasks[1].config, "inputs", safe_process=os.getpid())
    with closing(Crew()) as crew:
        crew.get_ready(Engine(workers=2), [task.clip for task in tasks])
        results = run_all([tasks[0], bad, *tasks[2:]], 2, crew=crew)
    assert [result.used for result in results] == [True, False, True, True]


@pytest.mark.slow
def test_workers_get_ready_before_there_is_work_stay_for_the_next_and_end_with_the_block(tasks):
    with closing(Crew()) as crew:
        crew.get_ready(Engine(workers=1), [task.clip for task in tasks])
        process, modules = crew.spread(_call, [os.getpid, loaded])
        assert "bpy" in modules
        results = run_all(tasks[:2], 1, crew=Lent(crew))
        assert [*crew.spread(_call, [os.getpid])] == [process]
    assert [result.used for result in results] == [True, True]
    assert not Path(f"/proc/{process}").exists()


def _call(work):
    return work()


class Lent(Crew):
    """A crew that is ended by whom it is of."""

    def __init__(self, crew):
        super().__init__()
        self.workers = crew.workers


def test_what_workers_die_of_is_done_here():
    with closing(Crew()) as crew:
        assert [*crew.spread(partial(_die_elsewhere, os.getpid()), [1, 2, 3])] == [1, 2, 3]
        assert [*crew.spread(partial(_die_elsewhere, os.getpid()), [4])] == [4]  # they are dead by now


def _die_elsewhere(here, item):
    if os.getpid() != here:
        os._exit(1)
    return item


def test_a_failure_while_workers_get_ready_ends_them_at_once(tasks):
    begun = []

    def fail():
        with closing(Crew()) as crew:
            crew.get_ready(Engine(workers=2), [tasks[0].clip])
            begun.append(crew.workers(1).submit(time.sleep, HANG_S))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert begun[0].cancelled() or begun[0].exception(HANG_S)


def test_a_cluster_brings_its_own_workers(tasks, monkeypatch):
    monkeypatch.setattr(workers, "local_executor", None)
    Crew().get_ready(Engine(scheduler="tcp://127.0.0.1:9"), [tasks[0].clip])


def loaded():
    return list(sys.modules)


@pytest.mark.slow
def test_a_clip_that_hangs_is_given_up_at_the_limit(tasks):
    first, engine = tasks[0], Engine(limit_s=8.0)
    bad = HangingTask(first.clip, first.out, first.config, "inputs", engine, safe_process=os.getpid())
    results = run_all([bad, tasks[1]], 2)
    assert [result.used for result in results] == [False, True]
    assert "longer than the limit of 8 s" in results[0].reason


@pytest.mark.slow
def test_no_marker_is_left_behind(tasks):
    with closing(Crew()) as crew:
        run_tasks(tasks[:2], 2, "", [].append, crew)
    assert not list((tasks[0].out / WORK / "running").iterdir())


def test_a_work_that_dies_costs_itself_alone():
    assert workers.run_alone(os._exit, 1) is None
    assert workers.run_alone(os.getpid) != os.getpid()


def command(library, out, *options):
    labels = library / "labels.csv"
    return [
        sys.executable, "-m", "headless", "run", library, "--out", out, "--labels", labels,
        "--patches", "8", "--workers", "1", "--no-pictures", "--no-report", *options,
    ]  # fmt: skip


def hashes(out):
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.suffix in (".csv", ".json", ".npz") and path.name not in ("state.json", "current.json")
    }


@pytest.fixture(scope="module")
def undisturbed(library, tmp_path_factory):
    out = tmp_path_factory.mktemp("undisturbed") / "out"
    subprocess.run(command(library, out), cwd=ROOT, check=True, capture_output=True)
    return out


@pytest.mark.slow
def test_two_runs_into_one_folder(library, tmp_path):
    out = tmp_path / "out"
    first = subprocess.Popen(command(library, out), cwd=ROOT, stdout=subprocess.DEVNULL)
    while not all((out / WORK / name).exists() for name in ("holder", "state.json")):
        assert first.poll() is None
        time.sleep(0.05)
    first.send_signal(signal.SIGSTOP)  # it holds the folder for as long as we look
    second = subprocess.run(command(library, out), cwd=ROOT, capture_output=True, text=True, check=False)
    status = subprocess.run(
        [sys.executable, "-m", "headless", "status", out],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    first.send_signal(signal.SIGCONT)
    assert second.returncode == 4
    assert "another run works in" in " ".join(second.stdout.split())
    assert "Running for" in status.stdout
    assert first.wait() == 0
    done = subprocess.run(
        [sys.executable, "-m", "headless", "status", out],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "Finished" in done.stdout
    assert "4 of 4 clips done" in done.stdout


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_is_said(library, tmp_path):
    (tmp_path / "file").write_text("in the way")
    done = subprocess.run(
        command(library, tmp_path / "file" / "out"), cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "file is not a folder: give another one" in " ".join(done.stdout.split())
    assert "Traceback" not in done.stdout + done.stderr


def held_to_permissions(arguments):
    """The command without the superuser's power to write where nobody may."""
    if os.geteuid() != 0:
        return arguments
    setpriv = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]
    if shutil.which("setpriv") is None or subprocess.run([*setpriv, "true"], check=False).returncode:
        pytest.skip("this is the superuser, who cannot drop the power to write everywhere here")
    return [*setpriv, *arguments]


@pytest.mark.slow
def test_a_read_only_folder_is_said_and_nothing_in_it_changes(library, undisturbed, tmp_path):
    out = shutil.copytree(undisturbed, tmp_path / "out")
    folders = [out, *(path for path in out.rglob("*") if path.is_dir())]
    try:
        for folder in folders:
            folder.chmod(0o555)
        for place in (out, out / "new"):
            done = subprocess.run(
                held_to_permissions(command(library, place)),
                cwd=ROOT, capture_output=True, text=True, check=False,
            )  # fmt: skip
            assert done.returncode == 1, done.stdout + done.stderr
            assert "cannot be written" in " ".join(done.stdout.split())
            assert "Permission denied" in " ".join(done.stdout.split())
            assert "Traceback" not in done.stdout + done.stderr
            assert hashes(out) == hashes(undisturbed)
    finally:
        for folder in folders:
            folder.chmod(0o755)
    subprocess.run(command(library, out), cwd=ROOT, check=True, capture_output=True)
    assert hashes(out) == hashes(undisturbed)


@pytest.mark.slow
def test_a_cluster_gives_the_same_bytes_even_when_a_worker_is_killed(library, undisturbed, cluster, tmp_path):
    address, processes = cluster.address, cluster.workers
    out = tmp_path / "out"
    process = subprocess.Popen(
        command(library, out, "--scheduler", address), cwd=ROOT, stdout=subprocess.PIPE
    )
    while process.poll() is None and not read_records(out):
        time.sleep(0.05)
    os.killpg(processes[0].pid, signal.SIGKILL)
    output = process.communicate(timeout=HANG_S)[0]
    assert process.returncode == 0, output
    assert hashes(out) == hashes(undisturbed)
