# SPDX-License-Identifier: GPL-3.0-or-later
"""Every file that the real data lists as a negative: a true sentence and exit code from `w2w inspect`."""

import csv

import pytest

from ..command_line import cli

pytestmark = pytest.mark.usefixtures("one_worker")

SKIPPED = {
    "mixamo/_broken/truncated_50pct_Walking.fbx": "or damaged: a record should end at byte 355,384",
    "mixamo/_broken/truncated_header_only.fbx": "it is cut short: 27 bytes",
    "mixamo/_broken/zero_bytes.fbx": "the file is empty (0 bytes)",
    "mixamo/_broken/lfs_pointer_Feminine_TPose.fbx": "it is a Git LFS pointer",
    "mixamo/_broken/static_mesh_box_001.fbx": "it holds no armature, only: mesh",
    "mixamo/keijiro__CMUMocap/Base.fbx": "its armature 'Armature' (22 bones) has no animation",
    "bvh/cmu_JonathanAlderson/oneFrame.bvh": "it holds a pose, not a motion: 1 frame in 'oneFrame'",
    "bvh/cmu_JonathanAlderson/kick.bvh": "it is damaged: its skeleton opens 7 braces and closes 12",
    "smpl_poses/hbertiche__NeuralClothSim/0000.npz": "(19, 65, 4), which look like quaternions",
    "smpl_poses/Meshcapade__smplcodec/apose_to_handsFront_smplx.npz": "it does not say its frame rate",
    "smpl_poses/Meshcapade__smplcodec/pose_avatar.smpl": "it holds a pose, not a motion: 1 frame",
    "smpl_poses/nghorbani__human_body_prior/body_pose_rnd.npz": "it holds data and no 'poses'",
}
"""What the file lacks, as its sentence must say it."""

USED = {
    "mixamo/GDDMN__Test_DigitalOxygen/X Bot@Flying Knee Punch Combo.fbx": "81 at 30 frames/s",
    "mixamo/W3bbieLabs__bullrun/Fast Run (3).fbx": "17 at 30 frames/s",
    "mixamo/keijiro__CMUMocap/135_01.fbx": "1517 at 30 frames/s",
    "mixamo/Uncleared__RootMotionNavMesh/Soccer Kick.fbx": "72 at 24 frames/s",
    "bvh/cmu_JonathanAlderson/pauseTest.bvh": "343 at 120",
    "bvh/pybvh/bvh_test3.bvh": "100 at 120",
    "smpl_poses/nghorbani__amass/amass_sample.npz": "601 at 120 frames/s",
}
"""Negatives only for naive readers (text FBX, two armatures, other rigs) or for their activity."""


def inspected(path):
    code, said = cli("inspect", path)
    assert "please report" not in said
    return code, said


def negatives(shared_data):
    """What the data's own table calls negative or broken, and all SMPL files."""
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        listed = {
            row["file"]
            for row in csv.DictReader(stream)
            if row["activity"] == "negative" or row["import_status"].startswith("EXC")
        }
    folders = (shared_data / "mixamo" / "_broken", shared_data / "smpl_poses")
    return listed | {
        path.relative_to(shared_data).as_posix()
        for folder in folders
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_none_of_the_negatives_is_left_out_here(shared_data):
    assert negatives(shared_data) == SKIPPED.keys() | USED.keys()


@pytest.mark.parametrize("file", SKIPPED)
def test_what_cannot_be_used_is_said(shared_data, file):
    code, said = inspected(shared_data / file)
    assert code == 1, said
    assert f"{file.rsplit('/', 1)[-1]} would be skipped: " in said
    assert SKIPPED[file] in said
    assert not said.endswith("..")


@pytest.mark.parametrize("file", USED)
def test_what_can_be_used_is_read(shared_data, file):
    code, said = inspected(shared_data / file)
    assert code == 0, said
    assert f"{file.rsplit('/', 1)[-1]} would be used" in said
    assert USED[file] in said
