# SPDX-License-Identifier: GPL-3.0-or-later
"""Worn sensors against clips of a library, from the files to the page."""

import gzip
import itertools
import json
import shutil

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.headless.app import APP
from w2w_studies.datasets.berkeley_mhad import MHAD_SITES
from w2w_studies.datasets.mighar import MIGHAR_SENSORS

ACTIONS = ("a03", "a05", "a06")


@pytest.fixture
def few(some_mhad):
    """Three actions of four people, twice each, of Berkeley MHAD."""
    return some_mhad(4, ACTIONS, ("r01", "r02"))


@pytest.mark.slow
def test_real_files_go_the_whole_way(few, shared_data, tmp_path):
    """A damaged file among them costs only itself."""
    library, out = tmp_path / "library", tmp_path / "out"
    shutil.copytree(shared_data / "bvh" / "bandai_namco", library)
    (library / "dataset-1_bow_broken_001.bvh").write_text("HIERARCHY\nROOT")
    result = CliRunner().invoke(APP, ["validate", "mhad", str(few), str(library), "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert "Not done: Kinect: no clip of the libraries takes part in 'Kinect'" in result.output
    content = json.loads((out / "validation_all_actions.json").read_text())
    assert tuple(content["sites"]) == MHAD_SITES
    assert set(content["by_activity"]) == {"bend", "wave two hands", "wave right hand"}
    notes = " ".join(content["notes"])
    assert "bend Bandai-Namco 3" in notes
    assert "Library clips that could not be used: 1; the first: dataset-1_bow_broken_001.bvh: " in notes
    assert 0 <= content["regret"]["lost"] <= 1
    assert content["regret"]["interval"][0] <= content["regret"]["lost"]
    summary = json.loads((out / "summary.json").read_text())
    assert [bar["what"] for bar in summary["all actions"]["bars"]] == [
        "rho of mean F1", "mean rho", "r over cells", "regret",
    ]  # fmt: skip
    assert len(summary["motion capture"]["trained_on_simulated"]) == 5
    report = (out / "report.md").read_text()
    assert "| asked for | found | reached |" in report
    assert "No activity is shown by two sources" in report
    assert (out / "cells_all_actions.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_the_truth_page_leaves_out_what_cannot_be_used(few, shared_data, tmp_path):
    library, out = shared_data / "bvh" / "bandai_namco", tmp_path / "out"
    result = CliRunner().invoke(
        APP,
        ["study", "truth", str(library), "--mhad", str(few), "--umafall", str(few), "--out", str(out)],
    )
    assert result.exit_code == 0, result.output
    assert "UMAFall is left out" in result.output
    assert "is no archive of UMAFall: it lacks acc_lsb_g" in " ".join(result.output.split())
    page = (out / "truth.md").read_text()
    assert "| Berkeley MHAD | all actions | 3, 6 |" in page
    assert "![Real against simulated F1](mhad/cells_all_actions.png)" in page
    assert not (out / "umafall").exists()


@pytest.mark.parametrize("command", [("validate", "mhad"), ("study", "truth")])
def test_an_only_library_of_which_nothing_is_used_is_no_success(command, some_mhad, tmp_path):
    """As UTD-MHAD's folder without its .mat files, with its npz in it."""
    few, utd = some_mhad(1, ("a03",), ("r01",)), tmp_path / "utd_mhad"
    utd.mkdir()
    np.savez(utd / "all.npz", a1_s1_t1_imu=np.zeros((9, 6)))
    real = [str(few)] if command[1] == "mhad" else ["--mhad", str(few)]
    given = [*command, *real, str(utd), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(APP, given, env={"COLUMNS": "400"})
    told = " ".join(result.output.split())
    assert result.exit_code == 2
    assert f"Nothing of {utd} is used: no file has a name that " in told
    assert "UTD-MHAD is read from the folder of Inertial and Skeleton" in told
    assert not (tmp_path / "out").exists()


def test_what_cannot_be_compared_gets_a_sentence(tmp_path):
    (tmp_path / "empty").mkdir()
    wrong = tmp_path / "wrong.npz"
    np.savez(wrong, x=np.zeros(3))
    result = CliRunner().invoke(
        APP, ["validate", "mhad", str(wrong), str(tmp_path / "empty"), "--out", str(tmp_path / "out")]
    )
    assert result.exit_code == 2
    assert "it holds no array named like s01_a01_r01_h01" in " ".join(result.output.split())
    result = CliRunner().invoke(APP, ["study", "truth", str(tmp_path), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "Point it to a data set at least: --mhad, --umafall, --dsads, --upfall, --mighar" in result.output
    given = ["study", "truth", str(tmp_path), "--mighar", str(tmp_path), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(APP, given)
    assert (result.exit_code, "--mighar needs --sensors" in result.output) == (2, True)
    assert not (tmp_path / "out").exists()


def garment(folder, sensors=(0, 1, 5, 9)):
    """Four people who walk and jog, twice each; the other sensors are still."""
    time, rng = np.arange(600) / 100, np.random.default_rng(0)
    for subject, (activity, pace) in itertools.product(range(1, 5), (("walking", 1.8), ("jogging", 2.7))):
        for number in (1, 2):
            rows = [["0"] * (9 * MIGHAR_SENSORS) for _ in time]
            for sensor in sensors:
                turn = 2 * np.pi * pace * time[:, None] * [1, 2, 1] + rng.uniform(0, 6, 3)
                acc, gyr = [0, 0, 1] + pace / 8 * np.sin(turn), 40 * pace * np.cos(turn)
                for row, values in zip(rows, np.hstack([acc, gyr]).tolist(), strict=True):
                    row[9 * sensor : 9 * sensor + 6] = [f"{value:.3g}" for value in values]
            path = folder / f"subject{subject}" / activity / f"data{number}.csv.gz"
            path.parent.mkdir(parents=True, exist_ok=True)
            lines = [",".join(["x"] * (9 * MIGHAR_SENSORS)), *(",".join(row) for row in rows)]
            path.write_bytes(gzip.compress("\n".join(lines).encode(), compresslevel=1))
    return folder


@pytest.mark.slow
def test_a_garment_goes_the_whole_way(shared_data, tmp_path):
    """Two of its sensors are at one site, whose score is their mean."""
    library, out = shared_data / "bvh" / "bandai_namco", tmp_path / "out"
    positions = tmp_path / "sensors.csv"
    rows = ("0,left wrist,", "1,left wrist,", "5,chest,", "9,right ankle,", "11,,")
    positions.write_text("\n".join(["sensor,region,vertex", *rows]))
    given = [str(garment(tmp_path / "mig")), str(library), "--sensors", str(positions), "--out", str(out)]
    result = CliRunner().invoke(APP, ["validate", "mighar", *given])
    assert result.exit_code == 0, result.output
    content = json.loads((out / "validation_all_activities.json").read_text())
    assert tuple(content["sites"]) == ("left wrist", "chest", "right ankle")
    assert set(content["by_activity"]) == {"walking", "running"}
    summary = json.loads((out / "summary.json").read_text())
    assert [bar["what"] for bar in summary["all activities"]["bars"]] == ["regret", "rho over ceiling"]


@pytest.mark.slow
def test_the_truth_page_holds_two_sets_one_of_them_a_garment(few, shared_data, tmp_path):
    out, positions = tmp_path / "out", tmp_path / "sensors.csv"
    positions.write_text("sensor,region,vertex\n0,left wrist,\n1,left wrist,\n5,chest,\n9,right ankle,\n")
    given = [str(shared_data / "bvh" / "bandai_namco"), "--mhad", str(few), "--mighar"]
    given += [str(garment(tmp_path / "mig")), "--sensors", str(positions)]
    result = CliRunner().invoke(APP, ["study", "truth", *given, "--out", str(out)])
    assert result.exit_code == 0, result.output
    page = (out / "truth.md").read_text()
    assert "| MIG HAR" in page
    assert "| Berkeley MHAD | " in page


def test_where_the_garments_sensors_are_is_asked_for(tmp_path):
    def told(*options):
        given = ["validate", "mighar", str(tmp_path), str(tmp_path), "--out", str(tmp_path / "out"), *options]
        result = CliRunner().invoke(APP, given, env={"COLUMNS": "400"})
        assert result.exit_code == 2
        return "".join(result.output.split())

    empty = tmp_path / "out" / "sensors.csv"
    assert f"{empty}liststhemall:givethoseyouwantaregionoravertex" in told()
    lines = empty.read_text().splitlines()
    assert (lines[0], lines[1], len(lines)) == ("sensor,region,vertex", "0,,", 397)
    empty.write_text("sensor,region,vertex\n0,chest,\n1,left wrist,\n2,tail,\n")
    assert 'noplacement,sensorsiteorregioniscalled"tail"' in told("--sensors", str(empty))
    assert told()
    assert empty.read_text().endswith("2,tail,\n")  # what a user wrote stays


def test_a_file_that_is_not_up_falls_is_refused(tmp_path):
    (tmp_path / "CompleteDataSet.csv").write_text("a,b\n1,2\n")
    given = ["validate", "upfall", str(tmp_path), str(tmp_path), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(APP, given, env={"COLUMNS": "400"})
    assert result.exit_code == 2
    told = " ".join(result.output.split())
    assert "is not UP-Fall's CompleteDataSet.csv: its first line lacks TimeStamps" in told
    assert not (tmp_path / "out").exists()
