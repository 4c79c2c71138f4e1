# SPDX-License-Identifier: GPL-3.0-or-later
"""Links, pipes, devices and names of any bytes in a library: none hangs a run or costs its result."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from w2w.core.library.library import Clip
from w2w.core.study.config import StudyConfig
from w2w.headless.app import APP
from w2w.headless.runs.clip import do_clip, file_sha256, record_death, work_in_worker
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.folder import make_folders

from ..clip_lists import skipped_clips, used_clips
from ..patience import HANG_S

pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="Windows has no such files and names"),
    pytest.mark.usefixtures("one_worker", "few_orders"),
]

ROOT = Path(__file__).resolve().parents[2]
GOOD = (
    ("Conqster__TheBarMan/Walking.fbx", "walking"),
    ("M3-org__CharacterStudio/StrutWalking.fbx", "walking"),
    ("lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Run.fbx", "running"),
    ("kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx", "running"),
)

FAST = ("--patches", "8", "--no-pictures", "--workers", "2", "--verbose")
BAD = {
    "loop.fbx": "it is a symbolic link that leads back to itself",
    "endless.fbx": "it is a link to a device, not a file",
    "pipe.bvh": "it is a named pipe, not a file",
    "pipe.npz": "it is a named pipe, not a file",
    "gone.fbx": "it is a link to a file that does not exist: nowhere",
    "unfetched.fbx": "it is a git-annex link whose content is not here: fetch it with 'git annex get'",
    "sparse.fbx": "it is 3.0 GiB large; a motion file may have 2 GiB at most: cut it into parts",
}


@pytest.fixture
def library(shared_data, tmp_path):
    """A library as an archive keeps it: links to a store of contents; one name is no text."""
    folder, store = tmp_path / "library", tmp_path / "store" / "annex" / "objects" / "ab"
    store.mkdir(parents=True)
    for number, (file, activity) in enumerate(GOOD):
        (folder / activity).mkdir(parents=True, exist_ok=True)
        content = store / f"SHA256E-s1--{number}"
        shutil.copy(shared_data / "mixamo" / file, content)
        name = os.fsdecode(b"gehen\xe4\xff.fbx") if number == 0 else Path(file).name
        (folder / activity / name).symlink_to(Path(os.path.relpath(content, folder / activity)))
    return folder


def add_bad(folder):
    (folder / "loop.fbx").symlink_to("loop.fbx")
    (folder / "endless.fbx").symlink_to("/dev/zero")
    os.mkfifo(folder / "pipe.bvh")
    os.mkfifo(folder / "pipe.npz")
    (folder / "gone.fbx").symlink_to("nowhere")
    (folder / "unfetched.fbx").symlink_to("../.git/annex/objects/ab/cd/SHA256E-s123--abcdef")
    with (folder / "sparse.fbx").open("wb") as stream:
        stream.truncate(3 * 2**30)


@pytest.mark.slow
def test_a_run_over_all_of_them_ends_with_its_report(library, tmp_path):
    add_bad(library / "walking")
    out = tmp_path / "out"
    result = CliRunner().invoke(APP, ["run", str(library), "--out", str(out), *FAST], env={"COLUMNS": "400"})
    assert result.exit_code == 0, result.output
    told = {file.removeprefix("walking/"): reason for file, reason in skipped_clips(out).items()}
    assert told == BAD
    used = used_clips(out)
    assert "walking/gehen%E4%FF.fbx" in {entry["file"] for entry in used}
    assert len(used) == len(GOOD)
    report = (out / "report.html").read_text(encoding="utf-8")
    shown = " ".join(result.output.split())
    for file, reason in BAD.items():
        assert file in shown
        assert reason in shown
        assert reason.replace("'", "&#39;") in report


@pytest.mark.parametrize(
    ("command", "file"), [("inspect", "endless.fbx"), ("inspect", "pipe.npz"), ("synth", "pipe.bvh")]
)
def test_one_such_file_alone_is_refused_at_once(tmp_path, command, file):
    add_bad(tmp_path)
    options = ["--patch", "left wrist", "--out", str(tmp_path / "out.csv")] if command == "synth" else []
    result = CliRunner().invoke(APP, [command, str(tmp_path / file), *options], env={"COLUMNS": "400"})
    assert result.exit_code == 1
    assert BAD[file] in " ".join(result.output.split())


@pytest.mark.slow
def test_under_a_locale_that_knows_no_accents(library, shared_data, tmp_path):
    """The console can spell neither the folder nor the file; the result must not be lost for it."""
    os.rename(library / "running", library / "läuft")  # noqa: PTH104
    bvh = shared_data / "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh"
    text = bvh.read_text(encoding="utf-8").replace("UpperArm_L", "Oberarm_ü")
    (library / "läuft" / "é.bvh").write_text(text, encoding="utf-8")
    environment = os.environ | {
        "LC_ALL": "C",
        "PYTHONUTF8": "0",
        "PYTHONCOERCECLOCALE": "0",
        "COLUMNS": "400",
    }
    environment.pop("PYTHONIOENCODING", None)
    command = [sys.executable, "-m", "headless"]
    run = [*command, "run", str(library), "--out", str(tmp_path / "aus é"), *FAST]
    result = subprocess.run(run, cwd=ROOT, env=environment, capture_output=True, timeout=HANG_S, check=False)
    assert b"Traceback" not in result.stderr, result.stderr.decode(errors="replace")
    assert result.returncode == 0, result.stdout.decode(errors="replace")
    assert rb"l\xe4uft" in result.stdout
    used = {entry["file"]: entry["activity"] for entry in used_clips(tmp_path / "aus é")}
    assert used["läuft/é.bvh"] == "läuft"
    assert used["walking/gehen%E4%FF.fbx"] == "walking"
    assert "Läuft" in (tmp_path / "aus é" / "report.html").read_text(encoding="utf-8")
    inspect = [*command, "inspect", str(library / "läuft" / "é.bvh")]
    result = subprocess.run(
        inspect, cwd=ROOT, env=environment, capture_output=True, timeout=HANG_S, check=False
    )
    assert result.returncode == 0, result.stderr.decode(errors="replace")
    assert rb"\xe9.bvh would be used" in result.stdout


def task(tmp_path, path):
    make_folders(tmp_path)
    return ClipTask(Clip(path, path.name, "clip", "walking"), tmp_path, StudyConfig(), "inputs")


def test_what_killed_a_worker_is_not_read_again_by_the_run(tmp_path):
    """The run's own process has no limit that would end it."""
    path = tmp_path / "walk.fbx"
    path.write_bytes(b"some FBX that kills")
    source = file_sha256(path)
    killed = task(tmp_path, path)
    killed.marker.parent.mkdir(parents=True, exist_ok=True)
    killed.marker.write_text(f"{source}\n")
    path.unlink()
    os.mkfifo(path)  # read now, it would be waited on for ever
    record = record_death(killed)
    assert (record["source"]["sha256"], bool(record["reason"])) == (source, True)
    assert record["key"] == killed.key(source)
    assert not killed.marker.exists()


def test_the_worker_notes_what_it_read_before_it_begins(tmp_path, monkeypatch):
    path = tmp_path / "walk.fbx"
    path.write_bytes(b"some FBX that kills")
    found = []

    def killing(task):
        found.append(task.marker.read_text().splitlines())
        raise MemoryError

    monkeypatch.setattr("w2w.headless.runs.clip._make", killing)
    work_in_worker(task(tmp_path, path))
    assert found == [[file_sha256(path), json.dumps(task(tmp_path, path).look())]]


def test_an_error_without_words_is_a_reason_all_the_same(tmp_path, monkeypatch):
    """An empty reason would count as a clip that is used."""
    path = tmp_path / "walk.fbx"
    path.write_bytes(b"some FBX")

    def failing(_):
        raise ValueError

    monkeypatch.setattr("w2w.headless.runs.clip._make", failing)
    record = do_clip(task(tmp_path, path))
    assert record["reason"] == "W2W failed on it, please report this: ValueError"
