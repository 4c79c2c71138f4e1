# SPDX-License-Identifier: GPL-3.0-or-later
"""A library of real clips, its tasks, and a real Dask cluster on this machine."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from w2w.core.body.body import Body
from w2w.core.library.library import read_library
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import place_patches
from w2w.headless.runs.clip import WORK
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.folder import make_folders

from ...patience import HANG_S
from ...real_clips import under_csv

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def library(shared_data, tmp_path_factory):
    return under_csv(shared_data, tmp_path_factory.mktemp("library"))


@pytest.fixture
def tasks(library, bundled_body, tmp_path):
    config = StudyConfig(patches=8)
    make_folders(tmp_path)
    bundled_body.save(tmp_path / WORK / "body.npz")
    place_patches(Body.bundled(), config).save(tmp_path / WORK / "patches.npz")
    clips = read_library(library, library / "labels.csv").clips
    return [ClipTask(clip, tmp_path, config, "inputs") for clip in clips]


@pytest.fixture
def four_patches(bundled_body, tmp_path):
    """A folder ready for clips, and a config of four patches."""
    out, config = tmp_path / "out", StudyConfig(patches=4)
    make_folders(out)
    bundled_body.save(out / WORK / "body.npz")
    place_patches(Body.bundled(), config).save(out / WORK / "patches.npz")
    return out, config


@dataclass
class Cluster:
    """A scheduler and its workers, each of them and its nanny a process group."""

    address: Path
    scheduler: subprocess.Popen
    workers: list = field(default_factory=list)

    def add_worker(self, **options):
        """Start a worker; options as of `Popen`."""
        command = ["worker", "--scheduler-file", self.address, "--nthreads", "1", "--no-dashboard"]
        self.workers.append(_dask(*command, start_new_session=True, **options))


def _dask(*arguments, **options):
    quiet = {"cwd": ROOT, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen([sys.executable, "-m", "dask", *arguments], **(quiet | options))


@pytest.fixture
def scheduler(tmp_path):
    """A real scheduler over loopback, without workers."""
    pytest.importorskip("distributed")
    address = tmp_path / "scheduler.json"
    local = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    process = _dask("scheduler", *local, "--scheduler-file", address)
    found = Cluster(address, process)
    until = time.monotonic() + HANG_S
    while not address.exists() and time.monotonic() < until:
        time.sleep(0.1)
    yield found
    for worker in found.workers:
        with suppress(ProcessLookupError):
            os.killpg(worker.pid, signal.SIGKILL)
    process.kill()
    for each in (*found.workers, process):
        each.wait(timeout=HANG_S)


@pytest.fixture
def cluster(scheduler):
    """A real scheduler and two worker processes."""
    for _ in range(2):
        scheduler.add_worker()
    return scheduler
