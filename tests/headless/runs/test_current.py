# SPDX-License-Identifier: GPL-3.0-or-later
"""The same command once more ranks nothing, unless something has changed."""

import hashlib
import json
import shutil
import time

import pytest
from typer.testing import CliRunner

from benchmarks.resume import UNLIKE
from w2w.headless.app import APP
from w2w.headless.commands import execute
from w2w.headless.runs import current
from w2w.headless.runs.clip_task import stamp

OPTIONS = ["--patches", "8", "--workers", "1", "--no-pictures", "--window", "1"]

pytestmark = pytest.mark.usefixtures("one_worker")


def run(library, out, *options):
    done = CliRunner().invoke(APP, ["run", str(library), "--out", str(out), *OPTIONS, *options])
    assert done.exit_code == 0, done.output
    return " ".join(done.output.split())


@pytest.fixture
def ranked(motions, tmp_path, monkeypatch):
    """A library with results, and how often the study was ranked after that."""
    library, out, times = tmp_path / "library", tmp_path / "out", []
    shutil.copytree(motions, library)
    run(library, out, "--folds", "2")
    rank = execute.rank_study
    monkeypatch.setattr(execute, "rank_study", lambda *given: (times.append(1), rank(*given))[1])
    return library, out, times


def test_sizes_and_times_tell_that_nothing_has_changed(ranked, monkeypatch):
    library, out, times = ranked
    read, make = [], execute.make_signals
    monkeypatch.setattr(execute, "make_signals", lambda *given: (read.append(1), make(*given))[1])

    def looked_into():
        read.clear()
        assert "Nothing has changed" in run(library, out, "--folds", "2")
        return bool(read)

    clip, features = sorted(library.rglob("*.npz"))[0], sorted((out / ".w2w" / "features").iterdir())[0]
    status = (out / ".w2w" / "state.json").read_bytes()
    assert not looked_into()
    assert (out / ".w2w" / "state.json").read_bytes() == status
    clip.touch()
    assert looked_into()
    assert not looked_into()
    assert run(library, out, "--folds", "2", "--log-json").count('"event": "clip"') == 8
    content = bytearray(features.read_bytes())
    content[-1] ^= 1
    features.write_bytes(content)  # as long as it was
    assert looked_into()
    assert not looked_into()
    (out / ".w2w" / "patches.npz").unlink()
    assert looked_into()
    monkeypatch.setattr(current, "stamp", lambda path: (*stamp(path), time.time_ns()))
    clip.touch()  # as if a clip's file changed again after the run had read it
    assert looked_into()
    monkeypatch.undo()
    monkeypatch.setattr(execute, "make_signals", lambda *given: (read.append(1), make(*given))[1])
    assert looked_into()
    assert not looked_into()
    assert not times


def hashes(out):
    files = [path for path in out.rglob("*") if path.is_file() and path.name not in UNLIKE]
    return {path.relative_to(out): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.slow
def test_the_same_command_ranks_only_what_has_changed(ranked):
    library, out, times = ranked
    before, answer = hashes(out), json.loads((out / "summary.json").read_text())["answer"]
    said = run(library, out, "--folds", "2")
    assert f"{answer['sentence']} Nothing has changed since the last run" in said
    sorted((out / "signals").iterdir())[0].unlink()  # made again as it was
    assert "Nothing has changed" in run(library, out, "--folds", "2")
    assert hashes(out) == before
    assert not times

    clips = sorted(library.rglob("*.npz"))
    (out / "report.html").unlink()
    run(library, out, "--folds", "2")
    assert len(times) == 1
    assert hashes(out) == before
    assert CliRunner().invoke(APP, ["place", str(out), "--max", "1", "--redraw"]).exit_code == 0
    run(library, out, "--folds", "2")
    assert len(times) == 2
    (out / ".w2w" / "current.json").write_text("{")
    run(library, out, "--folds", "2")
    assert len(times) == 3
    clips[0].rename(clips[-1].with_name("moved.npz"))
    run(library, out, "--folds", "2")
    assert len(times) == 4
    clips[1].unlink()
    run(library, out, "--folds", "3")
    assert len(times) == 5
    assert "Nothing has changed" in run(library, out, "--folds", "3")
    assert len(times) == 5
