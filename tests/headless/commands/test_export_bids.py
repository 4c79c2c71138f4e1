# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w export --for bids`: the BIDS validator has no error to report, whatever was recorded and named.

`make test-peers` brings the validator and names it in W2W_BIDS_VALIDATOR.
"""

import csv
import json
import os
import subprocess

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from w2w.core.motion.motion import Motion
from w2w.headless.app import APP

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("made_once_here")]

CLIPS = {
    f"{activity}{person}.npz": (name, who)
    for activity, name in enumerate(("sit to stand!", "Sit_to_stand", "走る"))
    for person, who in enumerate(("Zoë", "anna b"))
}
"""File -> activity and person, as people write them."""

WITHOUT_US = {"EVENTS_TSV_MISSING", "NO_AUTHORS", "TOO_FEW_AUTHORS"}
"""Warnings of what nobody but the dataset's owner knows; so are keys that BIDS recommends."""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Six made clips and their labels."""
    folder, time = tmp_path_factory.mktemp("bids"), np.arange(120) / 30
    for number, name in enumerate(CLIPS):
        axes = np.random.default_rng(number).normal(size=(24, 3)) / 5
        angles = np.sin(np.pi * (1 + number) * time)
        turns = Rotation.from_rotvec((angles[:, None, None] * axes).reshape(-1, 3)).as_matrix()
        pelvis = np.stack([time / 5, 0 * time, np.ones_like(time)], axis=1)
        Motion(turns.reshape(-1, 24, 3, 3), pelvis, 30.0).save(folder / name)
    with (folder / "labels.csv").open("w", newline="", encoding="utf-8") as table:
        csv.writer(table).writerows([("file", "activity", "subject"), *((k, *v) for k, v in CLIPS.items())])
    return folder


def w2w(*arguments):
    result = CliRunner().invoke(APP, [str(argument) for argument in arguments], env={"COLUMNS": "300"})
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("record", ["", "orientation,magnetometer,barometer"])
def test_bids_validator_finds_no_error(library, tmp_path, record):
    validator = os.environ.get("W2W_BIDS_VALIDATOR")
    if not validator:
        pytest.skip("W2W_BIDS_VALIDATOR does not name a BIDS validator: make test-peers")
    w2w(
        "run", library, "--labels", library / "labels.csv", "--out", tmp_path / "out", "--patches", 6,
        "--folds", 2, "--no-pictures", "--no-report", "--workers", 1, "--record", record,
    )  # fmt: skip
    w2w("export", tmp_path / "out", "--for", "bids", "--places", "all", "--out", tmp_path / "bids")
    told = subprocess.run(
        [validator, "--json", "--max-rows", "-1", str(tmp_path / "bids")], capture_output=True, text=True
    )
    assert told.returncode == 0, told.stdout + told.stderr
    report = json.loads(told.stdout)
    assert report["summary"]["modalities"] == ["motion"]
    assert set(report["summary"]["tasks"]) == {activity for activity, _ in CLIPS.values()}
    issues = {(issue["severity"], issue["code"]) for issue in report["issues"]["issues"]}
    expected = {("warning", code) for code in WITHOUT_US}
    assert {issue for issue in issues if not issue[1].endswith("_RECOMMENDED")} <= expected
