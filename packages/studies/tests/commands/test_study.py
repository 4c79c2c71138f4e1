# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's studies as commands."""

import csv
import json
import shutil
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer
from rich.console import Console
from typer.testing import CliRunner

from w2w.core.findings.sources import Origin, source_caution
from w2w.core.library.library import Clip, Library, read_library
from w2w.core.study.results import StudyResults
from w2w.headless.app import APP
from w2w_studies.commands.study_mixamo import show_placements
from w2w_studies.commands.study_rehab import by_quality, headings, rehab_takes
from w2w_studies.placements.activity_groups import PAPER_GROUPS, named_by_paper
from w2w_studies.placements.placement_patches import UNUSUAL, placement_patches
from w2w_studies.rehab.background import BACKGROUND
from w2w_studies.rehab.executions import FAULTS, WELL

CLIPS = {
    "mixamo/degocyx1211__GameJam1/Idle.fbx": ("idle", "balance_intensive"),
    "mixamo/kirbycope__godot-4.3-sandbox-3d/Idle.fbx": ("idle", "balance_intensive"),
    "mixamo/guysitstom__Second-Animation/Running.fbx": ("running", "locomotion_posture"),
    "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx": ("running", "locomotion_posture"),
    "mixamo/Sushim30__ARFitness/Burpee.fbx": ("burpee", "balance_intensive"),
}


def rows_of(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_unusual_placements_are_held_against_common_ones(drawn_results, tmp_path):
    study = StudyResults.load(drawn_results)
    lift, sit = study.utility.activities[1:]
    console = Console(record=True, width=200, file=(tmp_path / "log").open("w"))
    show_placements(study, {lift: "asymmetric", sit: "locomotion_posture"}, "right", console)
    told = console.export_text()
    near = placement_patches(study.body(), study.patches, "right", lambda _: None)
    assert told.count("too far to stand for it") == 11 - len(near)
    assert "Unusual placements against the common ones" in told
    assert "[dim]" not in told
    rows = rows_of(drawn_results / "unusual_places.csv")
    unusual, common = ([name for name in near if (name not in UNUSUAL) == usual] for usual in (False, True))
    assert len(unusual) > 1
    assert len(common) > 4
    assert len(rows) == 3 * len(unusual) * len(common)  # two groups and all
    for row in rows:
        low, difference, high = (float(row[name]) for name in ("low", "difference", "high"))
        assert difference == pytest.approx(float(row["f1"]) - float(row["common_f1"]), abs=2e-6)
        expected = "better" if low > 0 else "worse" if high < 0 else "cannot be told"
        assert row["verdict"] == expected
    table = rows_of(drawn_results / "tables.csv")
    assert {row["group"] for row in table} == {"asymmetric", "locomotion_posture", "all"}
    assert len(table) % len(near) == 0


@pytest.mark.slow
def test_the_mixamo_study_runs_on_a_library(shared_data, tmp_path):
    library = tmp_path / "library"
    lines = ["file,activity,group"]
    for file, labels in CLIPS.items():
        (library / file).parent.mkdir(parents=True, exist_ok=True)
        (library / file).symlink_to(shared_data / file)
        lines.append(",".join((file, *labels)))
    (tmp_path / "labels.csv").write_text("\n".join(lines))
    done = CliRunner().invoke(
        APP,
        ["study", "mixamo", str(library), "--out", str(tmp_path / "out"), "--labels",
         str(tmp_path / "labels.csv"), "--patches", "12", "--no-pictures"],
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert set(summary["activities"]) == {"idle", "running"}
    assert summary["clips"] == {"found": 4, "used": 4, "ranked": 4, "skipped": 0}
    assert "which take no part: 1" in done.output
    assert (tmp_path / "out" / "unusual_places.csv").is_file()
    assert (tmp_path / "out" / "report.html").is_file()


def test_the_papers_activities_are_known_by_mixamos_names(shared_data):
    library, group_of = named_by_paper(read_library(shared_data / "mixamo"))
    assert len(group_of) == 18
    assert Counter(group_of.values()) == dict.fromkeys(PAPER_GROUPS, 3)
    shown = {clip.file.rpartition("/")[2]: clip.activity for clip in library.clips}
    assert shown["aj@Walking.fbx"] == shown["Walking (1).fbx"] == shown["Walking_InPlace.fbx"] == "walking"
    assert shown["Great Sword High Spin Attack (4).fbx"] == "spin attack"
    assert shown["MmaKick.fbx"] == shown["Mma Kick.fbx"] == "pivot kick"
    assert not {"Running.fbx", "Idle.fbx", "Soccer Kick.fbx"} & set(shown)


@pytest.mark.usefixtures("one_worker")
def test_without_labels_a_library_of_other_names_is_refused(motions, tmp_path):
    done = CliRunner().invoke(APP, ["study", "mixamo", str(motions), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "holds no file that Mixamo calls" in " ".join(done.output.split())


@pytest.fixture
def made_study(motions, tmp_path):
    """A library of made motions and its labels; one activity has a single motion, one no group."""
    (motions / "once").mkdir()
    shutil.copy(motions / "slow" / "slow_0.npz", motions / "once")
    (motions / "loose").mkdir()
    shutil.copy(motions / "fast" / "fast_0.npz", motions / "loose" / "a.npz")
    groups = {"slow": "balance_intensive", "fast": "asymmetric", "once": "asymmetric", "loose": ""}
    lines = ["file,activity,group"]
    lines += [
        f"{path.relative_to(motions).as_posix()},{path.parent.name},{groups[path.parent.name]}"
        for path in sorted(motions.rglob("*.npz"))
    ]
    (tmp_path / "labels.csv").write_text("\n".join(lines))
    return motions, tmp_path / "labels.csv"


@pytest.mark.slow
@pytest.mark.usefixtures("one_worker")
def test_named_activities_are_taken_and_the_missing_named(made_study, tmp_path):
    library, labels = made_study
    base = ["study", "mixamo", str(library), "--out", str(tmp_path / "out"), "--labels", str(labels)]
    options = [
        "--patches", "8", "--no-pictures", "--no-report", "--folds", "2", "--window", "1",
        "--sensor", "ideal", "--rate", "40", "--band", "8", "--title", "ours", "--workers", "1",
    ]  # fmt: skip
    done = CliRunner().invoke(
        APP, [*base, *options, "--activities", "Slow, FAST, once, loose, flying"], env={"COLUMNS": "200"}
    )
    assert done.exit_code == 0, done.output
    output = " ".join(done.output.split())
    assert "Asked for, but not in the library: flying." in output
    assert "Asked for, but in no group (see --groups): loose." in output
    assert "Asked for, but with fewer than 2 motions: once." in output
    parameters = json.loads((tmp_path / "out" / "config.json").read_text())["parameters"]
    assert parameters["sensor"] == "ideal"
    assert parameters["synthesis"]["rate_hz"] == 40
    assert parameters["synthesis"]["cutoff_hz"] == 8
    assert (parameters["windows"]["length_s"], parameters["folds"], parameters["title"]) == (1, 2, "ours")
    assert set(json.loads((tmp_path / "out" / "summary.json").read_text())["activities"]) == {"slow", "fast"}
    done = CliRunner().invoke(APP, [*base, "--activities", "flying, diving"], env={"COLUMNS": "200"})
    assert done.exit_code == 2
    assert "the library has none of flying, diving" in " ".join(done.output.split())


def test_the_study_has_every_option_of_a_run():
    group = typer.main.get_command(APP)
    commands = {name: group.get_command(None, name) for name in ("run", "study")}
    run = {option for parameter in commands["run"].params for option in parameter.opts}
    study = {option for parameter in commands["study"].commands["mixamo"].params for option in parameter.opts}
    assert run - study == {"--leave-out", "--shard", "--config"}
    assert {
        "--sensor",
        "--classifier",
        "--by-subject",
        "--bodies",
        "--only",
        "--window",
    } <= study
    shared = {name: param for param in commands["run"].params for name in param.opts}
    for parameter in commands["study"].commands["mixamo"].params:
        for name in set(parameter.opts) & set(shared) - {"--labels"}:
            assert parameter.default == shared[name].default, name


def test_labels_without_groups_are_refused(tmp_path):
    (tmp_path / "a.fbx").write_bytes(b"")
    (tmp_path / "labels.csv").write_text("file,activity\na.fbx,walking\n")
    done = CliRunner().invoke(
        APP,
        ["study", "mixamo", str(tmp_path), "--out", str(tmp_path / "o"), "--labels",
         str(tmp_path / "labels.csv")],
    )  # fmt: skip
    assert done.exit_code == 2
    assert "columns 'activity' and 'group'" in " ".join(done.output.split())


def test_everybody_does_every_exercise_well_and_badly_and_what_is_between():
    takes = rehab_takes(10)
    assert len({take.file for take in takes}) == len(takes) == 10 * (2 * len(FAULTS) + len(BACKGROUND))
    for activity, faults in FAULTS.items():
        done = [take.execution for take in takes if take.activity == activity]
        assert done.count(WELL) == 10
        assert set(done) == {WELL, *faults}
    clips = tuple(Clip(Path(take.file), take.file, take.file, take.activity) for take in takes)
    asked = by_quality(Library(Path(), clips, "labels"), 10)
    assert set(asked.activities) == {f"{name} {how}" for name in FAULTS for how in (WELL, "badly")}
    assert set(asked.activities.values()) == {10}
    by_file = {take.file: take for take in takes}
    for clip in asked.clips:
        assert clip.activity.endswith(WELL) == (by_file[clip.file].execution == WELL)
    folders = [clip.file.partition("/")[0] for clip in asked.clips]
    shown = [
        Origin(clip.activity, clip.source, "", folder, "")
        for clip, folder in zip(asked.clips, folders, strict=True)
    ]
    assert source_caution([one._replace(source="") for one in shown])  # by its folders alone
    assert not source_caution(shown)


def test_the_figure_shows_the_exercises_first_and_says_what_is_background():
    utility = SimpleNamespace(activities=("arm_raise", "reaching", "stairs"), weights=np.array([1.0, 0, 2]))
    assert headings(utility) == [(0, "Arm raise"), (2, "Stairs"), (1, "Reaching (background)")]


@pytest.mark.slow
def test_the_rehabilitation_study_asks_both_questions(tmp_path):
    out = tmp_path / "rehab"
    options = ["--clips", "3", "--patches", "16", "--no-pictures", "--workers", "1"]
    done = CliRunner().invoke(APP, ["study", "rehab", "--out", str(out), *options])
    assert done.exit_code == 0, done.output
    which, how = (json.loads((out / name / "summary.json").read_text()) for name in ("results", "quality"))
    assert {name for name, weight in which["mean"]["weights"].items() if not weight} == set(BACKGROUND)
    assert which["worn_together"]["every_activity"] == 0.9
    assert set(which["worn_together"]["f1"]) == {*FAULTS, *BACKGROUND}
    assert "leave one of 3 subjects out" in which["protocol"]
    assert which["sensor"] == "watch"
    assert set(how["activities"]) == {f"{name} {way}" for name in FAULTS for way in (WELL, "badly")}
    assert set(how["mean"]["weights"].values()) == {1}
    with (out / "library" / "labels.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 3 * (2 * len(FAULTS) + len(BACKGROUND))
    assert {row["subject"] for row in rows} == {"S01", "S02", "S03"}
