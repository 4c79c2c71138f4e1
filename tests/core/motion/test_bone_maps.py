# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones of real rigs are found by name, whatever prefix, case or separator they carry."""

import json

import pytest

from w2w.core.body.skeleton import JOINT_INDEX, JOINT_NAMES
from w2w.core.motion.bone_maps import BoneMap, best_match, bundled_bone_maps, missing_joints, plain_name

MIXAMO = (
    "Hips Spine Spine1 Spine2 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand LeftHandMiddle1 "
    "RightShoulder RightArm RightForeArm RightHand RightHandMiddle1 LeftUpLeg LeftLeg LeftFoot LeftToeBase "
    "RightUpLeg RightLeg RightFoot RightToeBase"
).split()


@pytest.mark.parametrize(
    "prefix",
    ["", "mixamorig:", "mixamorig1:", "mixamorig4:", "mixamorig_", "Armature|mixamorig:", "Neo_", "4:"],
)
def test_mixamo_bones_under_every_prefix(prefix):
    bone_map, matched = best_match(["Armature", *(prefix + name for name in MIXAMO)])
    assert bone_map.name == "Mixamo"
    assert len(matched) == len(JOINT_NAMES)
    assert matched[JOINT_INDEX["left_shoulder"]] == 1 + MIXAMO.index("LeftArm")


def test_rigs_without_fingers_and_spine_bones_are_enough():
    few = [name for name in MIXAMO if name not in ("Spine1", "Spine2", "LeftHandMiddle1", "RightHandMiddle1")]
    _, matched = best_match(few)
    assert not missing_joints(matched)


def test_missing_joints_are_named():
    _, matched = best_match([name for name in MIXAMO if name != "LeftLeg"])
    assert missing_joints(matched) == ["left_knee"]


def test_an_unknown_rig_matches_little():
    _, matched = best_match(["bone_1", "bone_2", "bone_3"])
    assert len(missing_joints(matched)) == 13


def test_a_map_of_the_user_s_own_comes_first(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(
        json.dumps(
            {"name": "mine", "joints": {name: f"b {number}" for number, name in enumerate(JOINT_NAMES)}}
        )
    )
    bone_map, matched = best_match([f"B_{number}" for number in range(24)], [BoneMap.load(path)])
    assert bone_map.name == "mine"
    assert matched == {number: number for number in range(24)}


def test_a_match_is_its_caller_s_to_change():
    best_match(MIXAMO)[1].clear()
    assert not missing_joints(best_match(MIXAMO)[1])


@pytest.mark.parametrize("text", ["[]", "{}", '{"name": "x", "joints": {"tail": "Tail"}}', "nonsense"])
def test_a_file_that_is_no_bone_map_is_refused(tmp_path, text):
    path = tmp_path / "map.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"map\.json"):
        BoneMap.load(path)


def test_bundled_maps_name_every_required_joint_once():
    for bone_map in bundled_bone_maps():
        names = [name for names in bone_map.joints.values() for name in names]
        assert len(names) == len(set(names)), bone_map.name
        assert not missing_joints({JOINT_INDEX[joint]: 0 for joint in bone_map.joints}), bone_map.name


def test_plain_names():
    assert plain_name("mixamorig:Left_Arm") == plain_name("LeftArm") == plain_name("left arm") == "leftarm"
