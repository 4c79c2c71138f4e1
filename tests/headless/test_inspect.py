# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w inspect` says what a file holds and whether it would be used."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from headless.__main__ import APP

ROOT = Path(__file__).resolve().parents[2]


def inspect(path):
    result = CliRunner().invoke(APP, ["inspect", str(path)], env={"COLUMNS": "200"})
    return result.exit_code, " ".join(result.output.split())


def test_a_clip_that_would_be_used(shared_data):
    code, output = inspect(
        shared_data / "mixamo/MahindraVishal06__Third-PersonMovementSystem/Walking Turn 180.fbx"
    )
    assert code == 0
    assert "would be used" in output
    assert "67 bones, named as Mixamo does" in output
    assert "31 at 30 a second" in output
    assert "180 degrees" in output


def test_an_amass_clip(shared_data):
    code, output = inspect(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    assert code == 0
    assert "601 at 120 a second" in output


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("mixamo/_broken/zero_bytes.fbx", "the file is empty"),
        ("mixamo/M3-org__CharacterStudio/T-Pose.fbx", "a pose, not a motion"),
        ("smpl_poses/hbertiche__NeuralClothSim/0000.npz", "(19, 65, 4)"),
        ("README.md", "not a kind of motion file"),
        ("nowhere.fbx", "cannot be read"),
    ],
)
def test_a_file_that_would_not_be_used(shared_data, file, reason):
    code, output = inspect(shared_data / file)
    assert code == 1
    assert "would be skipped" in output
    assert reason in output
    assert "Traceback" not in output


def test_a_bone_map_of_the_user_s_own(shared_data, tmp_path):
    clip = shared_data / "mixamo/Conqster__TheBarMan/Walking.fbx"
    mine = tmp_path / "mine.json"
    joints = json.loads((ROOT / "assets/templates/bone_maps/mixamo.json").read_text())["joints"]
    mine.write_text(json.dumps({"name": "our own rig", "joints": joints}))
    result = CliRunner().invoke(APP, ["inspect", str(clip), "--bone-map", str(mine)], env={"COLUMNS": "200"})
    assert result.exit_code == 0
    assert "named as our own rig does" in result.output
    mine.write_text("{}")
    result = CliRunner().invoke(APP, ["inspect", str(clip), "--bone-map", str(mine)], env={"COLUMNS": "200"})
    assert result.exit_code == 2
    assert "is not a bone map" in " ".join(result.output.split())
