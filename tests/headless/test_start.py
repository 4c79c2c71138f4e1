# SPDX-License-Identifier: GPL-3.0-or-later
"""Output that is closed, full or read by nobody, and too little memory: a sentence and an exit code."""

import fcntl
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ..patience import HANG_S

if not sys.platform.startswith("linux"):
    pytest.skip("it needs /dev/full and /proc", allow_module_level=True)

ROOT = Path(__file__).resolve().parents[2]
UNWRITTEN = "Stopped, because the output cannot be written: "


def w2w(*arguments, stderr=subprocess.PIPE, **options):
    """The command line in a process of its own."""
    command = [sys.executable, "-c", "from w2w.headless.start import main; main()", *map(str, arguments)]
    return subprocess.Popen(command, cwd=ROOT, stderr=stderr, text=True, **options)


def ended(process):
    errors = process.communicate(timeout=HANG_S)[1]
    return process.returncode, errors.strip()


def without(*numbers):
    """Close standard streams, as `>&-` does."""

    def closed():
        for number in numbers:
            os.close(number)

    return closed


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [("sensors",), ("--help",), ("run", "nothing", "--out", "nowhere")],
)
def test_a_full_disk_is_said(command):
    with Path("/dev/full").open("w") as full:
        assert ended(w2w(*command, stdout=full)) == (1, f"{UNWRITTEN}No space left on device.")


@pytest.mark.slow
def test_a_reader_that_has_gone_is_said():
    reader, writer = os.pipe()
    os.close(reader)
    assert ended(w2w("run", "--help", stdout=writer)) == (1, f"{UNWRITTEN}Broken pipe.")
    os.close(writer)


@pytest.mark.slow
@pytest.mark.parametrize("closed", [(0, 1, 2), (1,), (2,)])
def test_streams_that_are_closed_are_left_alone(closed, motions):
    """Workers start, and nothing is written to a file that was opened under a stream's number."""
    file = next(motions.rglob("*.npz"))
    code, errors = ended(w2w("inspect", file, preexec_fn=without(*closed), stdout=subprocess.DEVNULL))
    assert (code, errors) == (0, "")


@pytest.mark.slow
def test_a_usage_error_keeps_its_code_where_it_cannot_be_said():
    with Path("/dev/full").open("w") as full:
        assert w2w("run", stderr=full).wait(timeout=HANG_S) == 2


@pytest.mark.slow
def test_a_signal_ends_a_command_whose_reader_has_stopped_reading():
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    os.write(writer, b"x" * 4096)
    process = w2w("sensors", stdout=writer)
    wait_until_blocked(process.pid)
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=HANG_S) == 143
    os.close(reader)
    os.close(writer)
    process.communicate()


def wait_until_blocked(process, seconds=HANG_S):
    """Wait until a process hears SIGTERM and does nothing for a second."""
    end, before = time.monotonic() + seconds, None
    while (now := (hears(process, signal.SIGTERM), spent(process))) != before or not now[0]:
        assert time.monotonic() < end
        before = now
        time.sleep(1)


def hears(process, number):
    status = Path(f"/proc/{process}/status").read_text()
    caught = next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(int(caught, 16) >> (number - 1) & 1)


def spent(process):
    """The processor's time that it has taken."""
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13]


def test_too_little_memory_to_start_is_said():
    def little():
        resource.setrlimit(resource.RLIMIT_AS, (150 * 2**20,) * 2)

    # with a single thread, OpenBLAS asks for its memory again and again instead of giving up
    surroundings = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    code, errors = ended(w2w("sensors", preexec_fn=little, stdout=subprocess.DEVNULL, env=surroundings))
    assert (code, errors) == (1, "There is too little memory for W2W to start (see ulimit -v).")
