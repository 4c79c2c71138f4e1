# SPDX-License-Identifier: GPL-3.0-or-later
"""A file that crashes, outlasts or overfills its reader is one row of those skipped; signals end it all."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

import w2w
from w2w.core.reading import guard
from w2w.headless.options import parse_bodies

from ..clip_lists import skipped_clips, used_clips
from ..command_line import cli
from ..hostile_c3d import KINDS, plant, write_hostile
from ..patience import HANG_S
from .conftest import QUICKLY

pytestmark = pytest.mark.usefixtures("few_orders", "made_once_here")

ROOT = Path(__file__).resolve().parents[2]
LOAD = "import sys, w2w; w2w.load(sys.argv[1])"


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """A file that appears when the reader begins."""
    return plant(tmp_path / "planted", monkeypatch)


@pytest.mark.later
@pytest.mark.parametrize("kind", KINDS)
def test_inspect_says_that_it_would_be_skipped(tmp_path, monkeypatch, begun, kind):
    monkeypatch.setattr(guard, "LIMIT_S", 50.0)
    monkeypatch.setattr(guard, "MEMORY", 2**31)
    (file,) = write_hostile(tmp_path / "library", (kind,))
    code, said = cli("inspect", file)
    assert begun.exists()
    assert code == 1
    assert f"{file.name} would be skipped: " in said
    if kind != "fills":
        assert "the program that reads it crashed, or took longer than 5 s" in said


@pytest.mark.later
@pytest.mark.parametrize("read", [w2w.load_body, lambda path: parse_bodies(str(path))])
def test_a_body_that_crashes_its_reader_is_refused(tmp_path, monkeypatch, read):
    (tmp_path / "bpy.py").write_text("import ctypes; ctypes.string_at(0)")
    (tmp_path / "body.fbx").write_bytes(b"Kaydara FBX Binary")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(ValueError, match=r"body\.fbx: the program that reads it crashed"):
        read(tmp_path / "body.fbx")


@pytest.mark.slow
def test_a_run_uses_all_others(tmp_path, motions, begun):
    write_hostile(motions / "fast")
    limits = ("--clip-limit", 20, "--clip-memory", 2, "--no-report")
    code, said = cli("run", motions, "--out", tmp_path / "out", *QUICKLY, *limits)
    assert code == 0, said
    assert begun.exists()
    assert len(used_clips(tmp_path / "out")) == 8
    reasons = skipped_clips(tmp_path / "out")
    assert reasons.keys() == {f"fast/{kind}.c3d" for kind in KINDS}
    for kind in ("hangs", "crashes"):
        assert "the program that reads it crashed, or took longer than 2 s" in reasons[f"fast/{kind}.c3d"]
    assert "memory" in reasons["fast/fills.c3d"]
    tried = begun.read_text().split()
    assert [tried.count(kind) for kind in ("hangs", "crashes")] == [1, 1]


@pytest.mark.later
def test_a_file_that_hangs_costs_a_tenth_of_its_limit_once_until_it_or_the_limit_changes(
    tmp_path, motions, begun
):
    (file,) = write_hostile(motions / "fast", ("hangs",))

    def skipped(limit_s, *more):
        words = "--clip-limit", limit_s, "--clip-memory", 2, "--no-report"
        code, said = cli("run", motions, "--out", tmp_path / "out", *QUICKLY, *words, *more)
        assert code == 0, said
        tried = begun.read_text().split() if begun.exists() else []
        begun.unlink(missing_ok=True)
        return tried, skipped_clips(tmp_path / "out")["fast/hangs.c3d"], "Nothing has changed" in said

    reason = "the program that reads it crashed, or took longer than 2 s or more than 2.0 GiB: it is damaged"
    tried, said, _ = skipped(20)
    assert (tried, reason in said, said.endswith("(see --clip-limit)")) == (["hangs"], True, True)
    assert skipped(20) == ([], said, True)
    os.utime(file)
    assert skipped(20) == ([], said, True)
    assert skipped(20, "--verify") == ([], said, False)
    assert skipped(30) == (["hangs"], said.replace("2 s", "3 s"), False)
    file.write_bytes(file.read_bytes() + b"0")
    assert skipped(30)[0] == ["hangs"]


@pytest.mark.later
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere the worker itself looks")
@pytest.mark.parametrize(
    ("command", "number", "code"),
    [
        (("-m", "headless", "run"), signal.SIGINT, 130),
        (("-m", "headless", "run"), signal.SIGTERM, 143),
        (("-c", LOAD), signal.SIGINT, None),
    ],
)
def test_a_signal_ends_what_waits_for_a_file_that_hangs(tmp_path, motions, begun, command, number, code):
    write_hostile(motions / "fast", ("hangs",))
    out = ("--out", str(tmp_path / "out")) if code else ()
    with subprocess.Popen(
        [sys.executable, *command, str(motions), *out],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # a background job is deaf to some
        env=os.environ | {"PYTHONPATH": f"{begun.parent}{os.pathsep}{ROOT}"},
    ) as process:  # fmt: skip
        end = time.monotonic() + HANG_S
        while not begun.exists():
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < end
            time.sleep(0.05)
        workers = psutil.Process(process.pid).children(recursive=True)
        process.send_signal(number)
        said, _ = process.communicate(timeout=HANG_S)
    assert workers
    assert not psutil.wait_procs(workers, timeout=HANG_S)[1]
    assert process.returncode == code if code else "KeyboardInterrupt" in said, said
