# SPDX-License-Identifier: GPL-3.0-or-later
"""The gait trial's phases, and the road from its BVH to a report."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.headless.app import APP
from w2w_studies.comparisons.gait import PHASES, phases
from w2w_studies.datasets.gait import read_gait

TRIAL = "S02-Trial-Walk-1"


def test_legs_swing_in_turns_as_in_walking(shared_data):
    found = phases(read_gait(shared_data / "imu" / "gait", TRIAL))
    share = np.bincount(found, minlength=len(PHASES)) / len(found)
    assert 0.1 < share[0] < 0.45
    assert share[1] == pytest.approx(share[2], abs=0.1)
    swings = [
        int(code) for code, before in zip(found[1:], found[:-1], strict=True) if code and code != before
    ]
    turns = [a != b for a, b in zip(swings[1:], swings[:-1], strict=True)]
    assert np.mean(turns) > 0.8


@pytest.mark.slow
def test_the_gait_trial_is_simulated_and_reported(shared_data, tmp_path):
    folder = shared_data / "imu" / "gait"
    result = CliRunner().invoke(APP, ["validate", "gait", str(folder), "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    signals = json.loads((tmp_path / "signals.json").read_text())
    assert len(signals) == 9
    assert min(found["gyr"][0] for found in signals.values()) > 0.9
    assert np.mean([found["acc"][0] for found in signals.values()]) > 0.7
    report = (tmp_path / "report.md").read_text()
    assert "energy of angular velocity | 0.9" in report
    taught = [line.split("|")[2] for line in report.splitlines() if line.startswith("| simulated, ")]
    f1 = [float(cell.split()[0]) for cell in taught]
    assert f1[1] > f1[0] + 0.2  # turned to its angle, against as it is


def test_a_folder_without_the_trial_gets_a_sentence(tmp_path):
    result = CliRunner().invoke(APP, ["validate", "gait", str(tmp_path), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "holds no files" in result.output.replace("\n", " ")
