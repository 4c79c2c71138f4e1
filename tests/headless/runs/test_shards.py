# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a library made one beside the other, by processes that know nothing of each other."""

import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

from w2w.headless.commands.run import part_of
from w2w.headless.runs.folder import FolderBusyError, only_run, only_shard

from ...command_line import cli

ROOT = Path(__file__).resolve().parents[3]
OPTIONS = "--patches 8 --workers 1 --no-pictures --no-report --folds 2 --window 1".split()

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


def run(library, out, *options):
    return cli("run", library, "--out", out, *OPTIONS, *options)


def hashes(out):
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.name not in ("state.json", "current.json", "lock", "records.jsonl")
    }


@pytest.mark.slow
def test_shards_in_any_order_give_what_one_run_gives(motions, tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert run(motions, whole)[0] == 0
    for shard in ("2/2", "1/2"):
        code, output = run(motions, parts, "--shard", shard)
        assert code == 0, output
        assert "Without --shard, the same command ranks all" in output
        assert not (parts / "utility.csv").exists()
    made = hashes(parts / "signals")
    assert len(made) == 8
    written = {path: path.stat().st_mtime_ns for path in (parts / "signals").iterdir()}
    assert run(motions, parts)[0] == 0
    assert {path: path.stat().st_mtime_ns for path in (parts / "signals").iterdir()} == written
    assert hashes(parts) == hashes(whole)


@pytest.mark.slow
def test_shards_at_once_give_the_same_bytes(motions, tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert run(motions, whole)[0] == 0
    command = [sys.executable, "-m", "headless", "run", motions, "--out", parts, *OPTIONS, "--shard"]
    shards = [
        subprocess.Popen([*command, f"{n}/4"], cwd=ROOT, stdout=subprocess.DEVNULL) for n in range(1, 5)
    ]
    assert [shard.wait() for shard in shards] == [0, 0, 0, 0]
    assert run(motions, parts)[0] == 0
    assert hashes(parts) == hashes(whole)


def test_a_shard_holds_itself_and_keeps_a_run_away(tmp_path):
    with only_shard(tmp_path, "1-of-2"), only_shard(tmp_path, "2-of-2"):
        with pytest.raises(FolderBusyError, match="shard 1-of-2"), only_shard(tmp_path, "1-of-2"):
            pass
        with pytest.raises(FolderBusyError, match="shard"), only_run(tmp_path):
            pass
    with only_run(tmp_path):
        pass


def test_a_shard_waits_for_no_run_that_holds_the_folder(motions, tmp_path, monkeypatch):
    monkeypatch.setattr("w2w.headless.runs.folder.PREPARING_S", 0.1)
    assert run(motions, tmp_path / "out", "--shard", "1/2")[0] == 0
    with only_run(tmp_path / "out" / ".w2w"):
        code, output = run(motions, tmp_path / "out", "--shard", "1/2")
    assert code == 4
    assert "another run works in" in output


def test_more_shards_than_clips_are_no_fault(motions, tmp_path):
    code, output = run(motions, tmp_path / "out", "--shard", "9/9")
    assert code == 0, output
    assert "0 of 0 clips are done" in output


@pytest.mark.parametrize("text", ["0/4", "5/4", "4", "a/b", "1/0", "-1/3", "1/2/3"])
def test_what_is_no_shard_is_refused(text, motions, tmp_path):
    with pytest.raises(ValueError, match="such as 17/400"):
        part_of(text)
    assert run(motions, tmp_path / "out", "--shard", text)[0] == 2
    assert not (tmp_path / "out").exists()
