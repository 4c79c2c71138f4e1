# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones of real rigs are found by name, whatever prefix, case or separator they carry."""

import json
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.bone_maps import BoneMap, best_match, bundled_bone_maps, missing_joints, plain_name
from w2w.core.retargeting.retarget import retarget

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


PREFIXES = (
    "",
    "B-",
    "B_",
    "DEF-",
    "Character1:",
    "bip01 ",
    "rig|",
    "mixamorig1:",
    "CC_Base_",
    "ValveBiped.",
    "4:",
)
SUFFIXES = ("", "_jnt", ".001", "-skin")
SIDED = (
    "{part}.{letter}",
    "{part}_{small}",
    "{part}-{letter}",
    "{side}{part}",
    "{letter}_{part}",
    "{part} {side}",
)


@pytest.mark.parametrize("bone_map", bundled_bone_maps(), ids=lambda bone_map: bone_map.name)
def test_every_rig_is_known_under_every_prefix_and_suffix(bone_map):
    """Bones as a map names them; whatever all names have in common, no other bone plays a joint."""
    first = [names[0] for names in bone_map.joints.values()]
    known = {JOINT_INDEX[joint]: number for number, joint in enumerate(bone_map.joints, start=1)}
    for prefix, suffix in product(PREFIXES, SUFFIXES):
        best, matched = best_match(["Armature", *(f"{prefix}{name}{suffix}" for name in first)])
        assert {joint: bone for joint, bone in matched.items() if joint in known} == known, (prefix, suffix)
        assert best.name == bone_map.name or prefix + suffix  # other families may write a side elsewhere


@pytest.mark.parametrize("pattern", SIDED)
@pytest.mark.parametrize("prefix", ["", "B-", "rig_"])
def test_sides_are_known_at_either_end(pattern, prefix):
    parts = ["UpLeg", "Leg", "Foot", "Arm", "ForeArm", "Hand"]
    sided = [
        prefix + pattern.format(part=part, side=side, letter=side[0], small=side[0].lower())
        for side in ("Left", "Right")
        for part in parts
    ]
    bone_map, matched = best_match([f"{prefix}Hips", *sided])
    assert bone_map.name == "Mixamo"
    assert not missing_joints(matched)
    assert matched[JOINT_INDEX["right_elbow"]] == 1 + len(parts) + parts.index("ForeArm")


def test_bones_with_a_prefix_are_found_among_others():
    """Some rigs have more bones for control than those that deform, which begin alike."""
    deform = [f"def_{name}" for name in MIXAMO]
    _, matched = best_match([f"ctrl {number}" for number in range(60)] + deform)
    assert matched[JOINT_INDEX["left_shoulder"]] == 60 + MIXAMO.index("LeftArm")


SOMA = {  # Kimodo's somaskel77 without eyes, jaw and fingers: offsets in cm, as a person's
    "Hips": ("", (0, 95, 0)), "Spine1": ("Hips", (0, 10, 0)), "Spine2": ("Spine1", (0, 12, 0)),
    "Chest": ("Spine2", (0, 14, 0)), "Neck1": ("Chest", (0, 20, 0)), "Neck2": ("Neck1", (0, 5, 0)),
    "Head": ("Neck2", (0, 5, 0)), "HeadEnd": ("Head", (0, 18, 0)),
    **{
        f"{side}{name}": (parent.replace("*", side), (way * x, y, z))
        for side, way in (("Left", 1), ("Right", -1))
        for name, parent, (x, y, z) in (
            ("Shoulder", "Chest", (6, 15, 0)), ("Arm", "*Shoulder", (12, 0, 0)),
            ("ForeArm", "*Arm", (28, 0, 0)), ("Hand", "*ForeArm", (26, 0, 0)),
            ("HandMiddle1", "*Hand", (9, 0, 0)), ("Leg", "Hips", (9, -4, 0)), ("Shin", "*Leg", (0, -42, 0)),
            ("Foot", "*Shin", (0, -42, 0)), ("ToeBase", "*Foot", (0, -6, 12)),
        )
    },
}  # fmt: skip
"""Each joint's parent and offset (NVIDIA's published table of names; the offsets are ours)."""


def soma_bvh(raised):
    """A BVH of that skeleton, whose left thigh is raised forward by so many degrees, frame by frame."""

    def joint(name, depth):
        pad, children = "  " * depth, [child for child, (parent, _) in SOMA.items() if parent == name]
        shift = "6 Xposition Yposition Zposition" if depth == 0 else "3"
        lines = [f"{pad}{'ROOT' if depth == 0 else 'JOINT'} {name}", pad + "{"]
        lines += [
            f"{pad}  OFFSET {' '.join(map(str, SOMA[name][1]))}",
            f"{pad}  CHANNELS {shift} Zrotation Xrotation Yrotation",
        ]
        lines += [line for child in children for line in joint(child, depth + 1)]
        lines += [] if children else [f"{pad}  End Site", pad + "  {", f"{pad}    OFFSET 0 5 0", pad + "  }"]
        return [*lines, pad + "}"]

    hierarchy = joint("Hips", 0)
    order = [line.split()[-1] for line in hierarchy if "JOINT" in line]
    at = 6 + 3 * order.index("LeftLeg") + 1
    frames = []
    for degrees in raised:
        row = [0.0, 95.0, 0.0, *[0.0] * (3 + 3 * len(order))]
        row[at] = -degrees
        frames.append(" ".join(map(str, row)))
    motion = ["MOTION", f"Frames: {len(frames)}", "Frame Time: 0.0333333"]
    return "\n".join(["HIERARCHY", *hierarchy, *motion, *frames]) + "\n"


def test_somas_legs_are_thighs(tmp_path, bundled_body):
    bone_map, matched = best_match(list(SOMA))
    assert bone_map.name == "SOMA"
    assert len(matched) == len(JOINT_NAMES)
    assert list(SOMA)[matched[JOINT_INDEX["left_hip"]]] == "LeftLeg"
    (tmp_path / "raise.bvh").write_text(soma_bvh(np.linspace(0, 60, 30)))
    found = retarget(read_bvh(tmp_path / "raise.bvh"), bundled_body)
    assert found.bone_map == "SOMA"
    turns = Rotation.from_matrix(found.motion.rotations[-1]).magnitude()
    first = Rotation.from_matrix(found.motion.rotations[0]).magnitude()
    assert np.degrees(turns - first)[JOINT_INDEX["left_hip"]] == pytest.approx(60, abs=6)
    others = [joint for joint in range(24) if joint != JOINT_INDEX["left_hip"]]
    assert np.abs(turns - first)[others].max() < 0.02


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


def test_a_bone_map_nested_without_end_is_refused(tmp_path):
    path = tmp_path / "deep.json"
    path.write_text("[" * 100_000)
    with pytest.raises(ValueError, match="is not a bone map"):
        BoneMap.load(path)


def test_the_joints_of_meta_s_rig_have_a_map():
    sides = (
        "upleg",
        "lowleg",
        "foot",
        "ball",
        "clavicle",
        "uparm",
        "lowarm",
        "wrist_twist",
        "wrist",
        "middle1",
    )
    names = ["body_world", "root", *(f"c_spine{k}" for k in range(4)), "c_neck", "c_head", "c_jaw"]
    names += [f"{side}_{part}" for side in "lr" for part in sides]
    bone_map, matched = best_match(names)
    assert (bone_map.name, len(matched)) == ("MHR", len(JOINT_NAMES))
    assert names[matched[JOINT_INDEX["right_wrist"]]] == "r_wrist"
    assert names[matched[JOINT_INDEX["pelvis"]]] == "root"
