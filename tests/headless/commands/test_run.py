# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run` on real files: the right results, twice the same bytes, everything skipped explained."""

import csv
import hashlib
import json
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.core.files import file_sha256
from w2w.headless.app import APP

from ...clip_lists import skipped_clips, used_clips
from ...real_clips import under_csv

pytestmark = pytest.mark.usefixtures("few_orders")

ROOT = Path(__file__).resolve().parents[3]
CLIPS = {
    "Conqster__TheBarMan/Walking.fbx": "walking",
    "kirbycope__godot-4.3-sandbox-3d/Walking_InPlace.fbx": "walking",
    "M3-org__CharacterStudio/StrutWalking.fbx": "walking",
    "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Unarmed Walk Forward.fbx": "walking",
    "guysitstom__Second-Animation/Running.fbx": "running",
    "kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx": "running",
    "degocyx1211__GameJam1/Idle.fbx": "idle",
    "kirbycope__godot-4.3-sandbox-3d/Idle.fbx": "idle",
    "Sushim30__ARFitness/Burpee.fbx": "burpee",
    "_broken/zero_bytes.fbx": "walking",
    "_broken/truncated_50pct_Walking.fbx": "walking",
}


WIDE = {"COLUMNS": "100"}


def run(*arguments):
    return CliRunner().invoke(APP, [str(argument) for argument in arguments], env=WIDE)


def study(library, out, *options):
    return run("run", library, "--out", out, "--labels", library / "labels.csv", "--patches", 16, *options)


@pytest.fixture(scope="module")
def library(shared_data, made_once):
    return made_once("clips of a run", partial(_library, shared_data))


def _library(shared_data, folder):
    under_csv(shared_data, folder, CLIPS)
    shutil.copy(shared_data / "mixamo/M3-org__CharacterStudio/Waving.fbx", folder / "not listed.fbx")


@pytest.fixture(scope="module")
def finished(library, one_worker, made_once):  # noqa: ARG001
    """A study, and what it said."""
    folder = made_once("run", partial(_run, library))
    return folder / "out", (folder / "said.txt").read_text(encoding="utf-8")


def _run(library, folder):
    done = study(library, folder / "out", "--workers", 1)
    assert done.exit_code == 0, done.output
    (folder / "said.txt").write_text(done.output, encoding="utf-8")


UNLIKE = ("state.json", "current.json")
"""One tells the time, the other whether there were pictures."""


def hashes(out):
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.suffix in (".csv", ".json", ".npz") and path.name not in UNLIKE
    }


def test_the_summary_explains_every_clip(finished):
    out, output = finished
    summary = json.loads((out / "summary.json").read_text())
    assert summary["clips"] == {"found": 12, "used": 9, "ranked": 8, "skipped": 3}
    reasons = skipped_clips(out)
    assert "empty" in reasons["_broken/zero_bytes.fbx"]
    assert "cut short" in reasons["_broken/truncated_50pct_Walking.fbx"]
    assert "labels.csv" in reasons["not listed.fbx"]
    assert summary["activities"]["walking"]["clips"] == 4
    assert "only one" in summary["left_out"]["burpee"]
    assert "zero_bytes.fbx" in output


def test_copies_are_named(finished):
    out, output = finished
    copy, first = "kirbycope__godot-4.3-sandbox-3d/Walking_InPlace.fbx", "Conqster__TheBarMan/Walking.fbx"
    summary = json.loads((out / "summary.json").read_text())
    assert summary["activities"]["walking"]["distinct_motions"] == 3
    same = {entry["file"]: entry["same_motion_as"] for entry in used_clips(out) if "same_motion_as" in entry}
    assert same == {copy: first}
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "1 clip counts as a copy of another" in report
    assert "sandbox_3d_Walking_InPlace (of Conqster_TheBarMan_Walking)" in report
    assert "more to know" in output


def test_the_table_has_a_row_a_patch_and_a_column_an_activity(finished):
    with (finished[0] / "utility.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 16
    assert list(rows[0])[:3] == ["patch", "region", "vertex"]
    for row in rows:
        scores = [float(row[name]) for name in ("idle", "running", "walking")]
        assert float(row["mean"]) == pytest.approx(np.mean(scores), abs=2e-6)
        assert all(0 <= score <= 1 for score in scores)


def test_the_recommendation_agrees_with_the_table(finished):
    out, _ = finished
    summary = json.loads((out / "summary.json").read_text())
    with (out / "utility.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    f1 = np.array([[float(row[name]) for name in ("idle", "running", "walking")] for row in rows])
    best = summary["best_single_patch"]
    assert best["mean_f1"] == pytest.approx(f1.mean(axis=1).max(), abs=2e-6)
    assert rows[best["patch"]]["region"] == best["region"]
    worn = summary["worn_together"]
    assert worn["reached"] == (round(worn["expected_f1"], 2) >= worn["target"])  # as shown
    for place in worn["places"]:
        assert place["mean_f1"] == pytest.approx(f1[place["patch"]].mean(), abs=2e-6)


def test_motions_and_signals_of_every_used_clip(finished):
    out, _ = finished
    for clip in used_clips(out):
        with np.load(out / "motions" / f"{clip['clip']}.npz", allow_pickle=False) as motion:
            assert motion["poses"].shape == (clip["frames"], 72)
            assert str(motion["activity"]) == clip["activity"]
        with np.load(out / "signals" / f"{clip['clip']}.npz", allow_pickle=False) as signals:
            assert signals["acc"].shape[1:] == (16, 3)
            assert abs(signals["acc"].shape[0] / 50 - clip["duration_s"]) < 0.1
            strength = np.median(np.linalg.norm(signals["acc"], axis=2))
            assert 8 < strength < 25  # gravity, and what moving adds


def test_pictures_and_the_blend_file(finished):
    out, _ = finished
    names = {path.stem for path in (out / "heatmaps").glob("*.png")}
    assert names == {"idle", "running", "walking", "mean", "subset"}
    assert (out / "study.blend").stat().st_size > 100_000
    assert f"Report:   {out / 'report.html'}" in finished[1].replace("\n", "")
    assert (out / "report.html").stat().st_size > 100_000


def test_the_config_names_versions_and_inputs(finished, library):
    config = json.loads((finished[0] / "config.json").read_text())
    assert config["parameters"]["patches"] == 16
    assert config["versions"]["numpy"] == np.__version__
    file = "degocyx1211__GameJam1/Idle.fbx"
    assert config["clips"]["sha256"] == file_sha256(finished[0] / "clips.jsonl")
    hashes = {clip["file"]: clip["sha256"] for clip in used_clips(finished[0])}
    assert hashes[file] == file_sha256(library / file)


@pytest.mark.slow
@pytest.mark.usefixtures("one_worker", "all_orders")
def test_the_same_input_gives_the_same_bytes_whatever_the_workers(library, tmp_path):
    """A program of its own has two workers, and draws no pictures."""
    assert study(library, tmp_path / "here", "--workers", 1).exit_code == 0
    options = ["--labels", library / "labels.csv", "--patches", "16", "--workers", "2", "--no-pictures"]
    command = [sys.executable, "-m", "headless", "run", library, "--out", tmp_path / "out", *options]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert hashes(tmp_path / "out") == hashes(tmp_path / "here")


@pytest.mark.slow
def test_another_seed_gives_other_noise(finished, library, tmp_path):
    assert study(library, tmp_path / "other", "--seed", 1, "--no-pictures", "--no-report").exit_code == 0
    first, other = hashes(finished[0]), hashes(tmp_path / "other")
    signals = [name for name in first if name.startswith("signals/")]
    assert len(signals) == 9
    assert all(first[name] != other[name] for name in signals)


@pytest.mark.slow
@pytest.mark.usefixtures("one_worker")
def test_a_second_run_takes_up_what_is_finished_repairs_what_is_damaged_and_may_be_strict(
    library, finished, tmp_path
):
    """With --strict the clips that are skipped fail the run, which has its results all the same."""
    out = shutil.copytree(finished[0], tmp_path / "out")
    before = hashes(out)
    signals = sorted((out / "signals").glob("*.npz"))
    times = {path: path.stat().st_mtime_ns for path in signals}
    assert len(times) == 9
    signals[0].write_bytes(b"damaged")
    signals[1].unlink()
    (out / "summary.json").unlink()
    assert study(library, out, "--no-pictures", "--workers", 1, "--strict").exit_code == 3
    assert hashes(out) == before
    assert all(path.stat().st_mtime_ns == times[path] for path in signals[2:])


def test_one_activity_is_not_enough_and_the_reason_is_said(library, tmp_path):
    labels = tmp_path / "labels.csv"
    labels.write_text(
        "file,activity\n" + "\n".join(f'"{file}",move' for file in CLIPS if "_broken" not in file)
    )
    result = run("run", library, "--out", tmp_path / "out", "--labels", labels, "--patches", 8)
    assert result.exit_code == 2
    assert "two activities that can be tested, and there is only move" in " ".join(result.output.split())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["run", "/nowhere", "--out", "x"], 2, "not a folder"),
        (["run", ".", "--out", "x", "--labels", "/nowhere.csv"], 2, "cannot be read"),
        (["run", "."], 2, "--out"),
        (["run", ".", "--out", "x", "--sensor", "nosuch"], 2, "nosuch"),
    ],
)
def test_wrong_use_is_explained(arguments, code, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clip.fbx").write_bytes(b"")
    result = run(*arguments)
    assert result.exit_code == code
    assert message in " ".join(result.output.split())


@pytest.mark.slow
def test_a_motion_of_two_subjects_is_said_and_the_run_goes_on(motions, tmp_path):
    shutil.copy(motions / "slow" / "slow_0.npz", motions / "slow" / "copy.npz")
    files = sorted(path.relative_to(motions).as_posix() for path in motions.rglob("*.npz"))
    people = {file: "AB"[number % 2] for number, file in enumerate(files)}
    people |= {"slow/slow_0.npz": "A", "slow/copy.npz": "B"}
    rows = [f"{file},{file.split('/')[0]},{people[file]}" for file in files]
    (motions / "labels.csv").write_text("\n".join(["file,activity,subject", *rows]) + "\n")
    out = tmp_path / "out"
    ended = run(
        "run", motions, "--out", out, "--by-subject", "--patches", "8", "--no-pictures", "--no-report"
    )
    assert ended.exit_code == 0
    said = "2 clips of A and B show the same motion as another subject's clip"
    assert said in " ".join(ended.output.split())
    assert said in str(json.loads((out / "summary.json").read_text())["cautions"])


def test_subjects_that_are_not_there_are_missed_before_any_work(motions, tmp_path):
    ended = run("run", motions, "--out", tmp_path / "out", "--by-subject")
    code, said = ended.exit_code, " ".join(ended.output.split())
    assert code == 2
    assert "--by-subject: leave-one-subject-out needs a subject for every clip, and 8 of 8 have none" in said
    assert "--labels" in said
    assert not (tmp_path / "out").exists()
    files = sorted(path.relative_to(motions).as_posix() for path in motions.rglob("*.npz"))
    (motions / "labels.csv").write_text(
        "file,activity,subject\n" + "".join(f"{file},{file.split('/')[0]},Anna\n" for file in files)
    )
    ended = run("run", motions, "--out", tmp_path / "out", "--by-subject")
    assert ended.exit_code == 2
    assert "needs two subjects, and all clips are of Anna" in " ".join(ended.output.split())


@pytest.mark.slow
def test_the_file_alone_is_the_command_too():
    command = [sys.executable, "headless/run.py", "--help"]
    wide = os.environ | WIDE
    done = subprocess.run(command, cwd=ROOT, env=wide, capture_output=True, text=True, check=True)
    assert "Folder of motion files" in done.stdout
    assert "--labels" in done.stdout
