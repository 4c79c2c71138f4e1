# SPDX-License-Identifier: GPL-3.0-or-later
"""Kills, a full disk, damage, a vanished file: nothing finished is lost, the bytes stay the same."""

import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from ...clip_lists import skipped_clips
from ...real_clips import in_folders
from ...robustness.resume import hashes

ROOT = Path(__file__).resolve().parents[3]
KILLS = 12
FULL_AT = 150_000
"""Bytes: motions fit on this disk, signals do not."""


def run(library, out, limit=None):
    def fill_disk():
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = subprocess.run(
        [sys.executable, "-m", "headless", "run", library, "--out", out, "--patches", "32",
         "--workers", "1", "--no-pictures", "--no-report"],
        cwd=ROOT, capture_output=True, text=True, check=False, preexec_fn=fill_disk,
    )  # fmt: skip
    assert "Traceback" not in done.stdout + done.stderr, done.stdout + done.stderr
    return done.returncode, " ".join(done.stdout.split())


@pytest.fixture
def library(shared_data, tmp_path):
    return in_folders(shared_data, tmp_path / "library")


@pytest.mark.slow
def test_a_full_disk_damage_and_a_vanished_file(library, tmp_path):
    out = tmp_path / "out"
    code, said = run(library, out, FULL_AT)
    assert code == 1
    assert "cannot be written" in said
    assert not list(out.rglob("*.part"))
    assert run(library, out)[0] == 0
    expected = hashes(out)

    signals = sorted((out / "signals").iterdir())
    whole = bytearray(signals[0].read_bytes())
    whole[len(whole) // 2] ^= 1
    signals[0].write_bytes(whole)
    signals[1].unlink()
    records = out / ".w2w" / "records.jsonl"
    lines = records.read_text().splitlines(keepends=True)
    records.write_text("".join([*lines[:2], lines[2][:-40] + "\n", *lines[3:]]))
    features = sorted((out / ".w2w" / "features").iterdir())
    features[3].write_bytes(b"")
    for folder in (out, out / "signals", out / ".w2w"):
        (folder / ".name.npz.x1y2z3.w2w.part").write_bytes(
            b"half"
        )  # as a kill in the middle of a write leaves it
    assert run(library, out)[0] == 0
    assert hashes(out) == expected

    (library / "running" / "Run.fbx").unlink()
    (library / "running" / "Run.fbx").symlink_to(tmp_path / "gone.fbx")
    code, said = run(library, out)
    assert code == 1  # running has one clip left
    assert "running/Run.fbx" in said
    ((file, reason),) = skipped_clips(out).items()
    assert file == "running/Run.fbx"
    assert "does not exist" in reason


@pytest.mark.slow
@pytest.mark.usefixtures("shared_data")
def test_runs_killed_at_drawn_moments_end_with_the_bytes_of_an_undisturbed_one(tmp_path):
    # in a process of its own: it forks the runs, and this one has threads
    found = tmp_path / "found.json"
    done = subprocess.run(
        [sys.executable, "-m", "tests.robustness.resume", "--kills", str(KILLS), "--seed", "5",
         "--json", found],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    counted = json.loads(found.read_text())
    assert counted["killed"] == KILLS
    assert counted["finished and compared"] >= 2
    between = [name for name in counted if name.startswith("killed with") and " 0 of" not in name]
    assert any(" 10 of" not in name for name in between), counted  # between two clips
    assert any(" 10 of" in name for name in between), counted  # after the last
