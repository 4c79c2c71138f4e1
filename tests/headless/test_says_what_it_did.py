# SPDX-License-Identifier: GPL-3.0-or-later
"""A run on labels with mistakes in them and windows too long: what it says, and the same wherever it lies."""

import csv
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.api.ranking import Ranking
from w2w.core.files import write_npz
from w2w.core.findings.summary import patch_table
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.headless.app import APP
from w2w.headless.options import _folder_name
from w2w.headless.runs import study, workers as runs_workers
from w2w.headless.runs.folder import picture_names
from w2w_studies.placements.score_table import ScoreRow, score_table
from w2w_studies.placements.score_text import _cell, write_scores

from ..clip_lists import skipped_clips

pytestmark = pytest.mark.usefixtures("few_orders")

LABELS = """sep=;
file;activity;subject
walk/0.npz;Walking;A
walk/1.npz;walking;B
run/0.npz;=cmd|'/c calc'!A1;A
run/1.npz;=cmd|'/c calc'!A1;B
bow/0.npz;AUX;A
bow/1.npz;aux ;B
lean.npz;lean;A
gone.npz;walking;A
also/gone.npz;walking;B
nothing.npz;;A
"""
KINDS = ("walk", "run", "bow")
LOCAL_EXECUTOR = runs_workers.local_executor
CAUTION = "from 2 clips only: too few for an interval"


def w2w(*arguments):
    return CliRunner().invoke(APP, [str(argument) for argument in arguments], env={"COLUMNS": "300"})


def write_library(folder: Path) -> None:
    """Seven clips of 3 s, one without a label and one that no row lists."""
    names = [f"{kind}/{number}" for kind in KINDS for number in range(2)] + ["lean", "nothing", "unlisted"]
    for number, name in enumerate(names):
        path = folder / f"{name}.npz"
        path.parent.mkdir(parents=True, exist_ok=True)
        kind = KINDS.index(path.parent.name) if path.parent.name in KINDS else 3
        phase = np.random.default_rng(number).uniform(0, 6, 72)
        poses = (0.2 + 0.15 * kind) * np.sin(2 * np.pi * (1 + kind) * np.arange(90)[:, None] / 30 + phase)
        arrays = {"poses": poses, "trans": np.zeros((90, 3)), "mocap_framerate": np.array(30.0)}
        write_npz(path, arrays, compress=True)
    (folder / "labels.csv").write_text(LABELS)


@pytest.fixture(scope="module")
def ran(made_once, one_worker):  # noqa: ARG001
    """The results of a run called in its own folder, and what it said."""
    folder = made_once("here", lambda here: _make(here, here / "library", "library", "out", 1))
    return folder / "out", (folder / "said.txt").read_text(encoding="utf-8")


def _make(place, lies, library, out, workers):
    write_library(lies)
    before = Path.cwd()
    os.chdir(place)
    options = ["--out", out, "--labels", f"{library}/labels.csv", "--patches", 8, "--no-pictures"]
    done = w2w("run", library, *options, "--workers", workers, "--window", 12, "--title", "My <shirt>")
    os.chdir(before)
    assert done.exit_code == 0, done.output
    (place / "said.txt").write_text(" ".join(done.output.split()), encoding="utf-8")


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes_wherever_it_lies(ran, tmp_path, monkeypatch):
    """Every file but those that tell times, by other workers; `study.blend` is not written here."""
    monkeypatch.setattr(runs_workers, "local_executor", LOCAL_EXECUTOR)
    lies, there = tmp_path / "deep" / "the same clips", tmp_path / "results of mine" / "out"
    _make(tmp_path, lies, str(lies), str(there), 2)
    one, other = (
        {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}
        for out in (ran[0], there)
    )
    assert set(one) == set(other)
    assert {"summary.json", "config.json", "utility.csv", "utility.npz", "report.html"} < set(one)
    tell_times = {f".w2w/{name}" for name in ("state.json", "current.json", "records.jsonl")}
    assert {name for name in one if one[name] != other[name]} <= tell_times
    for name, content in one.items():
        assert b"the same clips" not in content + other[name], name
        assert str(ran[0].parent).encode() not in content, name


def test_labels_that_match_nothing_are_counted_and_named(ran):
    out, output = ran
    assert "2 rows match no file: gone.npz and also/gone.npz." in output
    assert "1 row has no activity or no file name: nothing.npz." in output
    assert "1 file is not listed: unlisted.npz." in output
    assert (
        "'walking' and 'Walking' count as one activity, 'walking' (--exact-labels keeps them apart)" in output
    )
    summary = json.loads((out / "summary.json").read_text())
    labels = summary["labels"]
    assert labels["rows_without_file"] == ["gone.npz", "also/gone.npz"]
    assert labels["rows_without_activity"] == ["nothing.npz"]
    assert labels["files_not_listed"] == ["unlisted.npz"]
    assert labels["spellings"] == {"aux": ["aux", "AUX"], "walking": ["walking", "Walking"]}
    assert summary["labelled_by"] == "the file labels.csv"
    assert skipped_clips(out) == {
        "nothing.npz": "labels.csv gives it no activity",
        "unlisted.npz": "labels.csv does not list it",
    }
    assert "2 rows match no file" in (out / "report.html").read_text(encoding="utf-8")


def test_the_counts_agree_wherever_they_stand(ran):
    out, output = ran
    summary = json.loads((out / "summary.json").read_text())
    assert summary["clips"] == {"found": 9, "used": 7, "ranked": 6, "skipped": 2}
    sentence = (
        "6 of 9 clips ranked, in 3 activities; 1 clip could be used but belongs to 1 activity that could not "
        "be ranked; 2 skipped."
    )
    assert sentence in output
    assert sentence in (out / "report.html").read_text(encoding="utf-8")


def test_windows_long_for_the_clips_are_warned_of(ran):
    out, output = ran
    windows = json.loads((out / "summary.json").read_text())["windows"]
    median = windows.pop("median_clip_s")
    assert windows == {"length_s": 12.0, "stride_s": 6.0, "clips_shorter": 7}
    warning = f"windows of 12 s are {12 / median:.1f} times as long as the median clip ({median:.1f} s)"
    assert warning in output
    assert warning in (out / "report.html").read_text(encoding="utf-8")


def test_an_interval_of_two_clips_carries_its_caution(ran):
    out, output = ran
    summary = json.loads((out / "summary.json").read_text())
    assert summary["activities"]["walking"]["interval_caution"] == CAUTION
    assert "(from at most 2 clips per activity: too few for an interval)" in output
    assert "1.000 to 1.000" not in output
    assert "1.00–1.00" not in (out / "report.html").read_text(encoding="utf-8")


def test_the_console_says_what_the_sensors_reach_together(ran):
    out, output = ran
    worn = json.loads((out / "summary.json").read_text())["worn_together"]
    said = " ".join(output.split())
    assert worn["sentence"][1:] in said
    for number, place in enumerate(worn["places"], start=1):
        assert f"{number}. {place['product'] or place['name']}: F1" in said


def test_the_table_runs_nothing_in_a_spreadsheet(ran):
    header = (ran[0] / "utility.csv").read_text().splitlines()[0]
    assert header.startswith("patch,region,vertex,'=cmd|'/c calc'!A1,aux,walking,mean")


def test_every_column_and_line_has_a_name_of_its_own_whatever_activities_are_called(drawn_results, tmp_path):
    utility, patches = (
        UtilityMap.load(drawn_results / "utility.npz"),
        PatchSet.load(drawn_results / ".w2w" / "patches.npz"),
    )
    called = ("mean", "Patch", "region")
    assert len(utility.activities) == len(called)
    utility = replace(utility, activities=called)
    clusters = np.zeros(len(patches), int)
    header, first, *_ = csv.reader(patch_table(utility, patches, clusters).splitlines())
    assert header[3:6] == ["mean (activity)", "Patch (activity)", "region (activity)"]
    assert len({name.casefold() for name in header}) == len(header)
    np.testing.assert_allclose([float(cell) for cell in first[3:6]], utility.f1[0], atol=1e-6)
    ranking = Ranking(utility, patches, *[None] * 4)
    row = ranking._rows()[0]
    assert (row["patch"], row["region"]) == (0, patches.regions[0])
    assert row["mean"] == pytest.approx(utility.mean[0])
    assert row["mean (activity)"] == pytest.approx(utility.f1[0, 0])
    write_scores(tmp_path / "tables.csv", score_table(utility, [0], {}), ["wrist"], [0], utility)
    with (tmp_path / "tables.csv").open() as stream:
        listed = [row["activity"] for row in csv.DictReader(stream)]
    assert listed == ["mean (activity)", "Patch", "region", "mean", "expected mean"]


@pytest.mark.parametrize(("clips", "shown"), [(2, "few clips"), (4, "few clips"), (5, ".70-1")])
def test_a_table_shows_no_interval_of_few_clips(clips, shown):
    score, low, high = np.array([0.9]), np.array([0.7]), np.array([1.0])
    row = ScoreRow("", "walking", score, low, high, np.array([True]), clips, 8)
    assert shown in _cell(row, 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--window", "0.5", "--stride", "1"],
            "--stride must be at most the window's length (--window 0.5), not 1",
        ),
        (["--window", "nan"], "--window"),
        (["--stride", "0.01"], "--stride"),
        (["--leave-out", "dancing"], "--leave-out: no clip is labelled dancing"),
    ],
)
def test_messages_name_the_options(tmp_path, options, message):
    (tmp_path / "walk.npz").write_bytes(b"")
    done = w2w("run", tmp_path, "--out", tmp_path / "out", *options)
    assert done.exit_code == 2
    assert message in " ".join(done.output.split())
    assert "stride_s" not in done.output


def test_the_stride_follows_the_window():
    from w2w.core.windows.windows import WindowSpec
    from w2w.headless.options import window_spec

    assert window_spec(0.5, None) == WindowSpec(0.5, 0.25)
    assert window_spec(2.0, None) == WindowSpec()
    assert window_spec(2.0, 2.0) == WindowSpec(2.0, 2.0)


def test_pictures_and_bodies_have_names_that_every_system_takes():
    names = picture_names(("aux", "CON", "walking", "mean"))
    assert names[2] == "walking"
    assert not {name.lower() for name in names} & {"aux", "con", "mean"}
    assert _folder_name("some/CON.npz") == "body_CON.npz"
    assert _folder_name("male height=1.") == "male_height_1"
    assert _folder_name("nul.npz", "1.2:0") == "body_nul.npz_betas_1.2_0"


@pytest.mark.slow
@pytest.mark.usefixtures("one_worker")
def test_a_source_for_each_activity_is_warned_of(ran, tmp_path):
    output = ran[1]
    assert "tell the sources of the clips apart" not in output  # one system shows them all
    write_library(tmp_path / "library")
    rows = [f"{kind}/{number}.npz,{kind},{kind} suit" for kind in KINDS for number in range(2)]
    (tmp_path / "library" / "labels.csv").write_text("\n".join(["file,activity,source", *rows]))
    options = ["--labels", tmp_path / "library" / "labels.csv", "--patches", 8, "--workers", 1, "--max", 1]
    done = w2w("run", tmp_path / "library", "--out", tmp_path / "out", "--no-pictures", *options)
    assert done.exit_code == 0, done.output
    caution = (
        "the ranking may tell the sources of the clips apart, not the activities: bow comes from bow suit "
        "alone, run from run suit alone, walk from walk suit alone; take all activities from the same sources"
    )
    assert f"No answer yet: {caution}" in " ".join(done.output.split())
    first = json.loads((tmp_path / "out" / "summary.json").read_text())["cautions"][0]
    assert first["weight"] == "stops the answer"
    assert first["text"].startswith(caution)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert f"No answer yet: {caution}" in page
    assert f"<b>Stops the answer:</b> {caution}" not in page


TOO_ALIKE = [("rank_clips", "rank patches"), ("Choices", "choose sensors")]


@pytest.mark.usefixtures("one_worker")
@pytest.mark.parametrize(("step", "purpose"), TOO_ALIKE)
def test_clips_too_much_alike_are_no_fault_of_wishes(motions, tmp_path, monkeypatch, step, purpose):
    def alike(*_, **__):
        raise np.linalg.LinAlgError("the matrix is not positive definite")  # 2,000 copies of four clips do

    monkeypatch.setattr(study, step, alike)
    done = w2w("run", motions, "--out", tmp_path / "out", "--patches", "4", "--no-pictures", "--folds", "2")
    assert done.exit_code == 1
    said = " ".join(done.output.split())
    assert f"too few different motions to {purpose} by" in said
    assert "constraints" not in said
