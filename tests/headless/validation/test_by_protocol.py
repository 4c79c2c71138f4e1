# SPDX-License-Identifier: GPL-3.0-or-later
"""Worn sensors against clips of a library, from the files to the page."""

import json
import shutil

import numpy as np
import pytest
from typer.testing import CliRunner

from headless.__main__ import APP
from w2w.core.datasets.berkeley_mhad import MHAD_SITES

ACTIONS, PEOPLE = ("a03", "a05", "a06"), ("s01", "s02", "s03", "s04")


@pytest.fixture
def few(shared_data, tmp_path):
    """Three actions of four people, twice each, of Berkeley MHAD."""
    whole = np.load(shared_data / "imu" / "berkeley_mhad" / "acc.npz", allow_pickle=False)
    names = [
        name
        for name in whole.files
        if name[:3] in PEOPLE and name[4:7] in ACTIONS and name[8:11] in ("r01", "r02")
    ]
    path = tmp_path / "few.npz"
    np.savez(path, **{name: whole[name] for name in names})
    return path


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
    assert "Point it to a data set at least: --mhad, --umafall, --dsads" in result.output
    assert not (tmp_path / "out").exists()
