# SPDX-License-Identifier: GPL-3.0-or-later
"""Workers of the Blender program, with this Python in the program's place: the same pipes and deaths."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import psutil
import pytest

from w2w.core.reading.reader import ProgramExecutor

from ...patience import HANG_S

ROOT = Path(__file__).resolve().parents[3]
PARENT = """
import os, sys, time
from w2w.core.reading.reader import ProgramExecutor
executor = ProgramExecutor(2)
print(*[executor.submit(os.getpid).result() for _ in range(2)], flush=True)
executor.submit(time.sleep, 600)
time.sleep(600)
"""


class UntoldError(Exception):
    """Cannot be pickled back: it wants two arguments."""

    def __init__(self, first, second):
        super().__init__(first + second)


def fail_untold():
    raise UntoldError("not ", "told")


def shout():
    print("printed by an importer", flush=True)
    os.write(1, b"printed by C++\n")
    return "result"


@pytest.fixture
def executor():
    executor = ProgramExecutor(2)
    yield executor
    executor.shutdown(kill_workers=True)


def test_calls_are_done_in_other_processes_at_the_same_time(executor):
    pids = {executor.submit(_pid_after, 0.2) for _ in range(4)}
    found = {future.result(timeout=HANG_S) for future in pids}
    assert len(found) == 2
    assert os.getpid() not in found


def _pid_after(seconds):
    time.sleep(seconds)
    return os.getpid()


def test_an_exception_comes_back_and_the_worker_goes_on(executor):
    with pytest.raises(ZeroDivisionError):
        executor.submit(divmod, 1, 0).result(timeout=HANG_S)
    with pytest.raises(TypeError, match="missing 1 required positional argument"):
        executor.submit(fail_untold).result(timeout=HANG_S)
    assert executor.submit(divmod, 7, 2).result(timeout=HANG_S) == (3, 1)


@pytest.mark.slow
def test_what_is_printed_does_not_get_among_the_results(executor):
    assert [executor.submit(shout).result(timeout=HANG_S) for _ in range(3)] == ["result"] * 3


def test_a_dead_worker_breaks_what_is_not_done_and_nothing_before(executor):
    assert executor.submit(divmod, 7, 2).result(timeout=HANG_S) == (3, 1)
    futures = [executor.submit(os._exit, 1) for _ in range(3)]
    for future in futures:
        with pytest.raises(BrokenProcessPool):
            future.result(timeout=HANG_S)


def test_a_write_to_a_dead_worker_does_not_kill_the_program_as_it_would_kill_blender():
    code = """
import os, signal, sys, time
from w2w.core.reading.reader import ProgramExecutor
signal.signal(signal.SIGPIPE, signal.SIG_DFL)
executor = ProgramExecutor(1)
pid = executor.submit(os.getpid).result()
os.kill(pid, signal.SIGKILL)
time.sleep(0.3)
print(type(executor.submit(os.getpid).exception()).__name__)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=HANG_S, check=False
    )
    assert (done.returncode, done.stdout.strip()) == (0, "BrokenProcessPool"), done.stderr


def test_a_program_that_cannot_start_is_a_broken_worker():
    executor = ProgramExecutor(1, ["/bin/false"])
    with pytest.raises(BrokenProcessPool):
        executor.submit(os.getpid).result(timeout=HANG_S)
    executor.shutdown(kill_workers=True)


def test_no_worker_outlives_a_shutdown_in_the_middle_of_its_work():
    executor = ProgramExecutor(1)
    pid = executor.submit(os.getpid).result(timeout=HANG_S)
    hanging = executor.submit(time.sleep, 600)
    executor.shutdown(kill_workers=True)
    assert not psutil.pid_exists(pid)
    assert isinstance(hanging.exception(timeout=HANG_S), BrokenProcessPool)


HANGING = PARENT.replace("(2)", "(1)").replace(
    "time.sleep, 600", '__import__("re").match, "(a+)+$", 60 * "a" + "b"'
)
"""Keeps the interpreter's lock, as C may: no thread of the worker gets a turn."""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere the worker itself looks")
def test_no_worker_that_hangs_outlives_a_parent_that_was_killed():
    with subprocess.Popen([sys.executable, "-c", HANGING], cwd=ROOT, stdout=subprocess.PIPE) as parent:
        workers = [psutil.Process(int(pid)) for pid in set(parent.stdout.readline().split())]
        time.sleep(1)
        parent.send_signal(signal.SIGKILL)
    assert not psutil.wait_procs(workers, timeout=HANG_S)[1]


def test_no_worker_outlives_a_parent_that_was_killed():
    with subprocess.Popen([sys.executable, "-c", PARENT], cwd=ROOT, stdout=subprocess.PIPE) as parent:
        workers = [psutil.Process(int(pid)) for pid in set(parent.stdout.readline().split())]
        parent.send_signal(signal.SIGKILL)
    assert not psutil.wait_procs(workers, timeout=HANG_S)[1]
