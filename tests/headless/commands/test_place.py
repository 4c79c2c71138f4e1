# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w place` and the options of `w2w run`: another choice from a finished ranking, nothing baked again."""

import csv
import html
import json
import shutil

import bpy
import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.files import file_sha256
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.costs import is_as_good
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.answer import find_answer
from w2w.core.selection.constraints import Constraints
from w2w.core.selection.scored import ScoredMap
from w2w.core.study.choosing import TURNS
from w2w.core.study.results import StudyResults
from w2w.headless.runs.folder import only_run
from w2w.scene.files.study_file import read_record
from w2w_studies.placements.placement_patches import placement_patches

from ...clip_lists import skipped_clips
from ...command_line import cli
from ..conftest import write_motions

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


PACES = {"sit_to_stand": 0.5, "arm_raise_band": 0.7, "one_leg_stand": 1.0, "stair_climbing": 2.0}


@pytest.fixture(scope="module")
def study(made_once, tmp_path_factory):
    """A study of three clips an activity, under constraints; the copy is this process's own."""
    folder = made_once("place", _make)
    out = shutil.copytree(folder / "out", tmp_path_factory.mktemp("place") / "out")
    return out, (folder / "output.txt").read_text(encoding="utf-8")


def _make(folder):
    costs = folder / "costs.csv"
    costs.write_text("region,cost\nleg,2\n", encoding="utf-8")
    write_motions(folder / "library", PACES, 3)
    code, output = cli(
        *("run", folder / "library", "--out", folder / "out", "--patches", 48, "--no-pictures"),
        *("--workers", 1, "--forbid", "head,hand"),
        *("--max", 2, "--target", 1, "--cost", costs, "--leave-out", "stair_climbing", "--folds", 3),
    )
    assert code == 0, output
    (folder / "output.txt").write_text(output, encoding="utf-8")


def chosen(out, *options):
    (out / "choice.json").unlink(missing_ok=True)  # no command replaces a single file
    code, output = cli("place", out, "--out", out / "choice.json", *options)
    assert code == 0, output
    return json.loads((out / "choice.json").read_text()), output


def test_the_run_keeps_to_the_constraints_and_says_what_they_cost(study):
    out, output = study
    summary = json.loads((out / "summary.json").read_text())
    worn = summary["worn_together"]
    assert 1 <= len(worn["places"]) <= 2
    for place in [*worn["places"], summary["best_single_patch"]]:
        assert not {"head", "ear", "hand", "finger", "thumb", "palm"} & set(place["region"].split())
    assert worn["cost"] == sum(
        2.0 if set(place["region"].split()) & {"thigh", "knee", "shin", "calf", "ankle", "heel"} else 1.0
        for place in worn["places"]
    )
    assert "stair_climbing" not in summary["activities"]
    ranked_activities = sorted({*PACES} - {"stair_climbing"})
    for product in summary["answer"]["products"]:
        assert list(product["expected_f1_of"]) == ranked_activities
    assert any("--leave-out" in reason for reason in skipped_clips(out).values())
    ranked = StudyResults.load(out)
    allowed = Constraints(forbid=("head", "hand")).terms(ranked.patches).allowed
    said = find_answer(ScoredMap(ranked.utility, ranked.patches, ranked.body(), allowed)).sentence()
    assert summary["answer"]["sentence"] == said
    assert summary["map_sentence"] in output
    assert " ".join(output.split()).index(said) < " ".join(output.split()).index("One sensor on")
    assert worn["sentence"][1:] in output


def test_each_card_says_how_far_its_sensor_may_be_turned(study):
    out, _ = study
    with (out / "placements.csv").open(newline="", encoding="utf-8") as stream:
        table = list(csv.DictReader(stream))
    cards = json.loads((out / "summary.json").read_text())["cards"]
    assert cards
    assert [int(row["turn_deg"]) for row in table] == [card["turn_deg"] for card in cards]
    assert {card["turn_deg"] for card in cards} <= {0, *TURNS}


def test_the_ranking_on_file_is_whole(study):
    out, _ = study
    utility = UtilityMap.load(out / "utility.npz")
    with (out / "utility.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    np.testing.assert_allclose([float(row["mean"]) for row in rows], utility.mean, atol=1e-6)
    assert [int(row["rank_low"]) for row in rows] == utility.rank_low.tolist()
    assert [int(row["rank_high"]) for row in rows] == utility.rank_high.tolist()
    clusters = [int(row["cluster"]) for row in rows]
    assert set(clusters) == set(range(max(clusters) + 1))


@pytest.mark.slow
def test_what_is_not_given_is_as_in_the_run_and_an_empty_word_takes_it_back(study):
    out, _ = study
    as_run, _ = chosen(out)
    summary = json.loads((out / "summary.json").read_text())
    assert as_run["worn_together"] == summary["worn_together"]
    free, _ = chosen(out, "--forbid", "", "--max", 3)
    assert free["best_single_patch"]["expected_f1"] >= as_run["best_single_patch"]["expected_f1"]


def test_another_choice_from_the_same_ranking(study):
    out, _ = study
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*.npz")}
    left, output = chosen(out, "--only", "left", "--must", "left arm", "--max", 3, "--target", 1)
    worn = left["worn_together"]
    regions = [place["region"] for place in worn["places"]]
    assert all(region.startswith("left") for region in regions)
    assert any(region.split()[1] in ("upper", "elbow", "forearm", "wrist", "shoulder") for region in regions)
    assert len(worn["alternatives"]) == len(regions)
    assert worn["sentence"][1:] in " ".join(output.split())
    for f1 in ("expected_f1",):
        promised = [place[f"{f1}_so_far"] for place in worn["places"]]
        assert promised == sorted(promised)
        assert worn[f1] == promised[-1]
        low, high = worn[f"{f1}_interval"]
        assert low <= worn[f1] <= high
    assert before == {path: path.stat().st_mtime_ns for path in out.rglob("*.npz")}


@pytest.mark.slow
def test_every_activity_may_be_asked_to_reach_an_f1(study):
    out, _ = study
    asked, output = chosen(out, "--target", 0.05, "--every-activity", 1)
    worn = asked["worn_together"]
    assert worn["every_activity"] == 1
    assert worn["reached"] == (min(worn["f1"].values()) >= 1)
    assert "for every activity" in output
    free = chosen(out, "--target", 0.05)[0]["worn_together"]
    assert free["reached"]
    assert len(free["places"]) == 1


@pytest.mark.slow
def test_a_sensor_to_add_is_named_where_more_f1_is_shown_with_it(study):
    """The example of docs/designer.md: there is a watch anyway."""
    asked, output = chosen(study[0], "--must", "left thigh", "--max", 2, "--target", 0.05)
    (worn,) = asked["worn_together"]["places"]
    following = asked["worn_together"]["next_sensor"]
    assert "thigh" in worn["region"]
    assert ("the best sensor to add is" in output.lower()) == (following is not None)
    if following:
        assert following["patch"] != worn["patch"]
        assert round(following["expected_f1"], 2) > round(worn["expected_f1_so_far"], 2)
    assert chosen(study[0], "--max", 1, "--target", 0.05)[0]["worn_together"]["next_sensor"] is None


def hashes(folder):
    """Every file of a folder."""
    return {
        path.relative_to(folder).as_posix(): file_sha256(path) for path in folder.rglob("*") if path.is_file()
    }


WISHES = ("--only", "left", "--must", "left arm", "--max", 2, "--target", 0.97)


@pytest.fixture(scope="module")
def redrawn(study, tmp_path_factory):
    """A copy of the study's folder with another choice, and what was written of the same one."""
    folder = tmp_path_factory.mktemp("redrawn")
    before = hashes(study[0])
    code, output = cli("place", study[0], "--out", folder / "left", *WISHES)
    assert code == 0, output
    assert f"Written to {folder / 'left'}" in output
    assert hashes(study[0]) == before
    code, output = cli("place", study[0], "--out", folder / "choice.json", *WISHES)
    assert code == 0, output
    return folder / "left", json.loads((folder / "choice.json").read_text())


@pytest.mark.slow
def test_another_choice_goes_into_a_folder_of_its_own(study, redrawn):
    out, choice = redrawn
    summary, config = (json.loads((out / name).read_text()) for name in ("summary.json", "config.json"))
    first = json.loads((study[0] / "summary.json").read_text())
    of_answer = {name: summary[name] for name in ("regions", "cautions")}
    assert summary == {**first, **choice, **of_answer}
    assert config["parameters"]["constraints"]["only"] == ["left"]
    assert config["parameters"]["constraints"]["costs"] == [["leg", 2.0]]  # as in the run
    assert (config["parameters"]["max_places"], config["parameters"]["target"]) == (2, 0.97)
    results = StudyResults.load(out)
    assert results.config().constraints == Constraints(
        ("left",), ("head", "hand"), ("left arm",), (("leg", 2.0),)
    )
    for name in ("utility.csv", "utility.npz"):
        assert file_sha256(out / name) == file_sha256(study[0] / name)
    report = (out / "report.html").read_text(encoding="utf-8")
    assert choice["worn_together"]["sentence"][1:] in html.unescape(report)
    assert (out / "report.html").read_bytes() != (study[0] / "report.html").read_bytes()
    for name in ("mean", "subset", "sit_to_stand"):
        assert (out / "heatmaps" / f"{name}.png").stat().st_size > 10_000
    bpy.ops.wm.open_mainfile(filepath=str(out / "study.blend"))
    record, _ = read_record(bpy.data.objects["Body"])
    assert record.summary["worn_together"] == choice["worn_together"]
    assert record.parameters == config["parameters"]
    marked = [item["patch"] for item in bpy.data.collections["Chosen patches"].objects]
    assert marked == [place["patch"] for place in choice["worn_together"]["places"]]


@pytest.mark.slow
def test_a_choice_replaces_the_runs_where_that_is_asked_for(redrawn, tmp_path):
    out = tmp_path / "own"
    shutil.copytree(redrawn[0], out)
    before = hashes(out)
    wishes = ("--forbid", "head,hand", "--max", 1, "--target", 1)
    code, output = cli("place", out, *wishes)
    assert code == 0, output
    assert hashes(out) == before
    code, output = cli("place", out, "--redraw", "--out", tmp_path / "choice.json", *wishes)
    assert code == 0, output
    choice = json.loads((tmp_path / "choice.json").read_text())
    summary = json.loads((out / "summary.json").read_text())
    assert summary["worn_together"] == choice["worn_together"]
    assert StudyResults.load(out).config().constraints.forbid == ("head", "hand")
    after = hashes(out)
    assert after["study.blend"] != before["study.blend"]
    assert after["heatmaps/subset.png"] != before["heatmaps/subset.png"]
    listed = dict(
        reversed(line.split("  ")) for line in (out / ".w2w/written.sha256").read_text().splitlines()
    )
    for name in ("config.json", "summary.json", "report.html", "study.blend", "heatmaps/subset.png"):
        assert listed[name] == after[name]


@pytest.mark.slow
def test_nobody_elses_file_is_overwritten_and_no_other_folder(study, tmp_path):
    out = tmp_path / "own"
    shutil.copytree(study[0], out)
    (out / "study.blend").write_text("mine")
    before = hashes(out)
    code, output = cli("place", out, "--redraw")
    assert code == 2
    assert "already holds study.blend, which W2W did not write" in output
    assert hashes(out).items() >= before.items()
    code, output = cli("place", study[0], "--out", out)
    assert code == 2
    assert "is not empty: give a new folder" in output
    (out / "study.blend").unlink()
    with only_run(out / ".w2w"):
        code, output = cli("place", out, "--redraw")
    assert code == 4
    assert "another run works in" in output


def test_a_comparison_is_written_where_it_is_asked_for(study, tmp_path):
    one, other = sorted(PatchSet.load(study[0] / ".w2w" / "patches.npz").names)[:2]
    code, output = cli("place", study[0], "--compare", f"{one}, {other}", "--out", tmp_path / "c.json")
    assert code == 0, output
    written = json.loads((tmp_path / "c.json").read_text())
    assert sorted(entry["name"] for entry in written) == [one, other]
    for entry in written:
        assert entry["costs_interval"][0] <= entry["costs"] <= entry["costs_interval"][1]
    code, output = cli("place", study[0], "--compare", one, "--out", tmp_path / "folder")
    assert code == 2
    assert "--compare chooses nothing" in output


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--only", "left", "--forbid", "left"], "nothing is left to choose from"),
        (["--must", "tail"], "no patch is called 'tail'"),
        (["--must", "left,right", "--max", "1"], "2 patches are required"),
        (["--cost", "missing.csv"], "missing.csv"),
    ],
)
def test_what_cannot_be_met_is_refused_in_words(study, options, complaint):
    code, output = cli("place", study[0], *options)
    assert code == 2
    assert complaint in output


def test_a_folder_without_a_finished_run_is_refused(tmp_path):
    code, output = cli("place", tmp_path)
    assert code == 2
    assert "not the results folder of a finished run: summary.json is missing" in output


def test_the_papers_sets_are_chosen_from_a_finished_run(study):
    out, _ = study
    code, output = cli("study", "paper", out)
    assert code == 0, output
    sets = json.loads((out / "paper_sets.json").read_text())
    places = sets["subset"]["places"]
    assert 1 <= len(places) <= 2  # under the run's own wishes
    for place in [*places, *sets["exact"]["places"]]:
        assert not {"head", "ear", "hand", "finger", "thumb", "palm"} & set(place["region"].split())
        assert 0 <= place["expected_f1_so_far"] <= 1
    assert [entry["sensors"] for entry in sets["together"]] == list(range(1, len(places) + 1))
    alone = sets["together"][0]  # the map's own F1, but for a ridge of its own
    assert alone["mean_f1"] == pytest.approx(places[0]["mean_f1"], abs=0.15)
    for said in (sets["joint"]["sentence"], sets["subset"]["sentence"], sets["greedy_and_exact"]):
        assert said[1:] in output
    code, output = cli("study", "paper", out, "--must", "tail")
    assert code == 2
    assert "no patch is called 'tail'" in output


def test_tables_have_a_cell_an_activity_and_placement(study, tmp_path):
    out, _ = study
    groups = tmp_path / "groups.csv"
    groups.write_text("activity,group\nsit_to_stand,legs\none_leg_stand,legs\n", encoding="utf-8")
    code, output = cli("tables", out, "--groups", groups)
    assert code == 0, output
    with (out / "tables.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    patches = PatchSet.load(out / ".w2w" / "patches.npz")
    near = placement_patches(Body.bundled(), patches, "left", lambda _: None)
    assert 5 < len(near) < 11  # on 48 patches some have none near enough: that is said, and they are left out
    assert output.count("too far to stand for it") == 11 - len(near)
    assert list(dict.fromkeys(row["placement"] for row in rows)) == list(near)
    assert [int(row["patch"]) for row in rows[: len(near)]] == [found.patch for found in near.values()]
    assert [(row["group"], row["activity"]) for row in rows[:: len(near)]] == [
        ("legs", "one_leg_stand"),
        ("legs", "sit_to_stand"),
        ("legs", "mean"),
        ("all", "arm_raise_band"),
        ("all", "mean"),
        ("all", "expected mean"),
    ]
    utility = UtilityMap.load(out / "utility.npz")
    for row in rows:
        assert float(row["low"]) <= float(row["f1"]) <= float(row["high"])
        if row["activity"] in utility.activities:
            expected = utility.f1[int(row["patch"]), utility.activities.index(row["activity"])]
            assert float(row["f1"]) == pytest.approx(float(expected), abs=1e-6)
        if row["activity"] == "expected mean":
            patch = int(row["patch"])
            assert float(row["f1"]) == pytest.approx(float(utility.expected_mean[patch]), abs=1e-6)
            assert row["same_as_best"] == (
                "yes" if is_as_good(utility.expected_mean.max() - utility.expected_mean[patch]) else "no"
            )
    first = output[output.index("Placements, left side") : output.index("legs")]
    ranked = sorted(rows[-len(near) :], key=lambda row: -float(row["f1"]))
    found = [first.index(f"│ {row['placement']} ") for row in ranked]
    assert found == sorted(found)
    assert "lateral" in output
    code, output = cli("tables", out, "--groups", out / "utility.csv")
    assert code == 2
    assert "needs the columns 'activity' and 'group'" in output


WEIGHED = ("--background", "One leg stand", "--target", 1, "--max", 2)


@pytest.mark.slow
def test_another_mean_is_ranked_as_a_run_would(study, made_once, tmp_path):
    """Nothing is baked again, and the folder of the choice is that of a run with the same weights."""
    weights = tmp_path / "weights.csv"
    weights.write_text("activity,weight\nsit_to_stand,3\n", encoding="utf-8")
    asked = (*WEIGHED, "--weights", weights)
    run_out = shutil.copytree(study[0], tmp_path / "run")
    made = made_once("place", _make)
    code, told = cli(
        *(
            "run",
            made / "library",
            "--out",
            run_out,
            "--patches",
            48,
            "--no-pictures",
            "--workers",
            1,
            "--folds",
            3,
        ),
        *("--leave-out", "stair_climbing", *asked),
        *("--forbid", "head,hand", "--max", 2, "--target", 1, "--cost", made / "costs.csv"),
    )
    assert code == 0, told
    before = hashes(study[0])
    code, output = cli("place", study[0], "--out", tmp_path / "place", *asked)
    assert code == 0, output
    assert hashes(study[0]) == before
    explained = "The mean over 2 activities is weighted (arm_raise_band 1, sit_to_stand 3); background"
    assert explained in told
    assert explained in output
    for name in ("utility.npz", "utility.csv"):
        assert file_sha256(tmp_path / "place" / name) == file_sha256(run_out / name) != before[name]
    utility = UtilityMap.load(run_out / "utility.npz")
    first = UtilityMap.load(study[0] / "utility.npz")
    assert utility.weights.tolist() == [1, 0, 3]
    np.testing.assert_array_equal(utility.predictions, first.predictions)
    np.testing.assert_allclose(utility.mean, first.f1 @ [0.25, 0, 0.75], rtol=1e-5)
    by_run, by_place = (
        json.loads((out / "summary.json").read_text()) for out in (run_out, tmp_path / "place")
    )
    assert by_place == by_run
    assert by_run["mean"]["weights"] == {"arm_raise_band": 1, "one_leg_stand": 0, "sit_to_stand": 3}
    parameters = json.loads((tmp_path / "place" / "config.json").read_text())["parameters"]
    assert parameters["background"] == ["One leg stand"]
    assert parameters["weights"] == [["sit_to_stand", 3.0]]
    page = html.unescape((tmp_path / "place" / "report.html").read_text(encoding="utf-8"))
    assert explained in page
    assert "Activities that count (mean)" in page
    assert "One leg stand (background)" in page
    assert "tells 2 activities apart, and from the background," in page
    back, output = chosen(tmp_path / "place", "--background", "", "--weights", equal_weights(tmp_path))
    assert back["mean"] == json.loads((study[0] / "summary.json").read_text())["mean"]
    assert "The mean" not in output


def equal_weights(folder):
    (folder / "equal.csv").write_text("activity,weight\nsit_to_stand,1\n", encoding="utf-8")
    return folder / "equal.csv"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--background", "juggling"), "background: no clip is labelled juggling; there are arm_raise_band"),
        (("--background", "arm_raise_band,one_leg_stand,sit_to_stand"), "none of the activities"),
        (("--weights", "none.csv"), "none.csv cannot be read"),
    ],
)
def test_a_mean_of_nothing_is_refused(study, options, message):
    code, output = cli("place", study[0], *options)
    assert code == 2
    assert message in output
