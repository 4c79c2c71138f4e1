# SPDX-License-Identifier: GPL-3.0-or-later
"""Workers of a cluster die of anything: no clip is blamed for it, and nothing is waited for without end."""

import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cloudpickle
import psutil
import pytest

from w2w.headless.runs import cluster as module
from w2w.headless.runs.clip import TRIES, try_alone
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.cluster import EngineError, connected
from w2w.headless.runs.records import keeping, read_records
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
            with (self.out / "crashes").open("a") as stream:
                stream.write("x")
            os.kill(os.getpid(), signal.SIGSEGV)
        return super().key(source_sha256)


cloudpickle.register_pickle_by_value(sys.modules[CrashingTask.__module__])


def many(tasks, count):
    """The tasks over and over, each clip under a name of its own."""
    copies = [replace(task.clip, name=f"{task.clip.name}_{n}") for n in range(count) for task in tasks]
    return [replace(tasks[0], clip=clip) for clip in copies]


def kill_at_random(cluster, over):
    """Kill one worker process after another, which its nanny replaces, but no clip's every try."""
    chance, kills = random.Random(3), 0
    while kills < TRIES - 1 and not over.wait(chance.uniform(0.5, 3.0)):
        nanny = psutil.Process(chance.choice(cluster.workers).pid)
        for child in nanny.children(recursive=True):
            if "spawn_main" in " ".join(child.cmdline()):
                child.kill()
                kills += 1
    return kills


@pytest.mark.slow
def test_workers_killed_over_and_over_cost_no_clip(tasks, cluster):
    wanted, over, kills = many(tasks, 40), threading.Event(), []
    killer = threading.Thread(target=lambda: kills.append(kill_at_random(cluster, over)))
    killer.start()
    told = []
    try:
        run_tasks(wanted, 1, str(cluster.address), told.append, Crew())
    finally:
        over.set()
        killer.join()
    assert kills[0] >= 3
    assert [record["reason"] for record in told] == [""] * len(wanted)
    assert len({record["clip"] for record in told}) == len(wanted)  # each once


@pytest.mark.slow
def test_a_clip_that_crashes_its_worker_alone_and_twice_is_recorded_and_the_others_are_used(tasks, cluster):
    bad = CrashingTask(tasks[1].clip, tasks[1].out, tasks[1].config, "inputs", safe_process=os.getpid())
    results = run_all([tasks[0], bad, *tasks[2:]], 1, str(cluster.address))
    assert [result.used for result in results] == [True, False, True, True]
    assert "the program that reads it crashed" in results[1].reason
    kept = read_records(tasks[0].out)
    assert kept[bad.clip.name]["reason"] == results[1].reason  # for later runs
    assert len((tasks[0].out / "crashes").read_text()) >= 3  # beside others, and twice alone
    assert all(kept[task.clip.name]["reason"] == "" for task in (tasks[0], *tasks[2:]))


class _Killed:
    """A future of a task at which workers were killed."""

    def result(self):
        from distributed import KilledWorker

        raise KilledWorker("task", None, 3)


def test_a_clip_whose_worker_was_killed_from_outside_is_left_to_the_next_run(tasks, monkeypatch):
    monkeypatch.setattr(module, "_submit", lambda _client, _task: _Killed())
    monkeypatch.setattr(module, "wait_for", lambda _client, future: future)
    record = try_alone(tasks[0], partial(module._once, None))
    assert record["reason"].startswith("not done yet")
    with keeping(tasks[0].out, {}) as keep:
        keep(record)
    assert not read_records(tasks[0].out)


def said_of(scheduler):
    with pytest.raises(EngineError) as caught, connected(str(scheduler)):
        pass
    return str(caught.value)


def test_a_scheduler_that_is_not_there_is_said(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "ANSWER_S", 1.0)
    assert "no Dask scheduler answers" in said_of("tcp://127.0.0.1:9")
    assert "cannot be read" in said_of(tmp_path / "missing.json")
    (tmp_path / "wrong.json").write_text('["no scheduler"]')
    assert "is no scheduler file" in said_of(tmp_path / "wrong.json")
    (tmp_path / "wrong.json").write_bytes(b"\xff\x00")
    assert "is no scheduler file" in said_of(tmp_path / "wrong.json")
    assert "no Dask scheduler answers" in said_of("nonsense://127.0.0.1:9")


@pytest.mark.slow
def test_a_scheduler_without_workers_is_said(monkeypatch, scheduler):
    monkeypatch.setattr(module, "ANSWER_S", 2.0)
    assert "has no workers" in said_of(scheduler.address)


@pytest.mark.slow
def test_workers_with_a_broken_or_missing_version_are_said(scheduler, tmp_path):
    (tmp_path / "w2w").mkdir()
    (tmp_path / "w2w" / "__init__.py").write_text("raise ImportError('broken')")
    scheduler.add_worker(cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path)})
    assert "1 of 1 Dask workers have another or a broken version of W2W" in said_of(scheduler.address)


@pytest.mark.slow
def test_workers_with_another_version_are_said(cluster, monkeypatch):
    monkeypatch.setattr(module, "code_sha256", other_code)
    assert "have another or a broken version" in said_of(cluster.address)


def other_code():
    """Another hash in each process."""
    return str(os.getpid())


def run_on(cluster, library, out):
    return subprocess.Popen(
        [
            sys.executable, "-m", "headless", "run", library, "--out", out,
            "--labels", library / "labels.csv", "--patches", "8", "--no-pictures", "--no-report",
            "--scheduler", cluster.address,
        ],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("ended", ["scheduler", "workers"])
def test_a_scheduler_or_workers_killed_during_the_run_end_it(ended, library, cluster, tmp_path):
    out = tmp_path / "out"
    process = run_on(cluster, library, out)
    while process.poll() is None and not list((out / ".w2w" / "running").glob("*")):
        time.sleep(0.05)
    if ended == "scheduler":
        cluster.scheduler.kill()
    for worker in cluster.workers if ended == "workers" else ():
        os.killpg(worker.pid, signal.SIGKILL)
    output = process.communicate(timeout=HANG_S)[0]
    assert process.returncode == 1
    assert "Traceback" not in output, output[-1500:]
    problem = json.loads((out / "summary.json").read_text())["problem"]
    assert "what is finished is kept" in problem
