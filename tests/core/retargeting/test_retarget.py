# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion carried over another skeleton and back is the same motion, whatever the rest pose."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.retargeting.bone_maps import BoneMap, bundled_bone_maps
from w2w.core.retargeting.retarget import BY_STRUCTURE, is_crumpled, retarget
from w2w.core.rotations import smallest_rotation

MIXAMO_NAMES = (
    "Hips LeftUpLeg RightUpLeg Spine LeftLeg RightLeg Spine1 LeftFoot RightFoot Spine2 LeftToeBase "
    "RightToeBase Neck LeftShoulder RightShoulder Head LeftArm RightArm LeftForeArm RightForeArm LeftHand "
    "RightHand LeftHandMiddle1 RightHandMiddle1"
).split()

TURN = Rotation.from_euler
SIDES = ("left", "right")


def arms_at(degrees):
    """A rest pose with both arms lowered from the T by so much."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    rotations[0, JOINT_INDEX["left_shoulder"]] = TURN("y", degrees, degrees=True).as_matrix()
    rotations[0, JOINT_INDEX["right_shoulder"]] = TURN("y", -degrees, degrees=True).as_matrix()
    return rotations


def as_source(body, motion, rest_rotations, scale=1.0, yaw=0.0, roll_seed=0):
    """The same motion as a Mixamo-named rig would hold it: another rest pose, unit, roll and heading."""
    rolls = Rotation.random(N_JOINTS, random_state=roll_seed).as_matrix()
    heading = TURN("z", yaw, degrees=True).as_matrix()
    rest_turns, rest_heads = joint_transforms(body, Motion(rest_rotations, body.joints[:1], 1.0))
    turns, heads = joint_transforms(body, motion)

    def matrices(rotations, positions):
        result = np.zeros((*positions.shape[:-1], 4, 4))
        result[..., :3, :3] = scale * (heading @ rotations @ rolls)
        result[..., :3, 3] = scale * (positions @ heading.T)
        result[..., 3, 3] = 1
        return result

    return SourceMotion(
        tuple(MIXAMO_NAMES),
        np.array(PARENTS),
        matrices(rest_turns, rest_heads)[0],
        matrices(turns, heads),
        motion.rate,
    )


@pytest.mark.parametrize("lowered", [0, 45, 80])
@pytest.mark.parametrize(("scale", "yaw"), [(1.0, 0.0), (0.013, 90.0), (120.0, -137.0)])
def test_the_motion_comes_back_whatever_the_rest_pose_unit_roll_and_heading(
    bundled_body, waving, lowered, scale, yaw
):
    result = retarget(
        as_source(bundled_body, waving, arms_at(lowered), scale, yaw, roll_seed=3), bundled_body
    )
    expected = waving.rotations.copy()
    expected[:, 0] = TURN("z", yaw, degrees=True).as_matrix() @ expected[:, 0]
    np.testing.assert_allclose(result.motion.rotations, expected, atol=1e-9)
    assert result.scale == pytest.approx(1 / scale)


def test_the_path_is_kept_up_to_one_lift(bundled_body, waving):
    motion = retarget(as_source(bundled_body, waving, arms_at(30), 0.01), bundled_body).motion
    lift = motion.pelvis - waving.pelvis
    np.testing.assert_allclose(lift, np.broadcast_to(lift[0], lift.shape), atol=1e-9)
    np.testing.assert_allclose(lift[0, :2], 0, atol=1e-9)


def test_a_leg_that_is_torn_off_in_some_frames_does_not_change_the_size(bundled_body, waving):
    source = as_source(bundled_body, waving, arms_at(30), 0.01)
    torn = [MIXAMO_NAMES.index(f"{side}{part}") for side in ("Left", "Right") for part in ("Leg", "Foot")]
    source.matrices[7:12, torn, :3, 3] += [0, 0, 0.05]  # five metres
    assert retarget(source, bundled_body).scale == pytest.approx(100)


def test_a_body_of_other_proportions_keeps_the_directions_of_its_limbs(bundled_body, waving):
    joints = bundled_body.joints * [1.2, 1.0, 0.9]
    joints[:, 1] += 0.02 * np.arange(N_JOINTS) / N_JOINTS
    other = replace(bundled_body, joints=joints)
    result = retarget(as_source(bundled_body, waving, arms_at(0)), other)
    _, positions = joint_transforms(other, result.motion)
    _, expected = joint_transforms(bundled_body, waving)
    for start, end in (
        ("left_shoulder", "left_elbow"),
        ("right_elbow", "right_wrist"),
        ("left_hip", "left_knee"),
    ):
        a, b = JOINT_INDEX[start], JOINT_INDEX[end]
        ours, theirs = positions[:, b] - positions[:, a], expected[:, b] - expected[:, a]
        cosine = np.sum(ours * theirs, 1) / np.linalg.norm(ours, axis=1) / np.linalg.norm(theirs, axis=1)
        np.testing.assert_allclose(cosine, 1, atol=1e-9)


def test_fingers_toes_and_spine_bones_may_be_missing(bundled_body, waving):
    source = as_source(bundled_body, waving, arms_at(0))
    kept = [
        i
        for i, name in enumerate(MIXAMO_NAMES)
        if name not in ("Spine1", "Neck", "LeftToeBase", "LeftHandMiddle1")
    ]
    parents = []
    for bone in kept:
        parent = PARENTS[bone]
        while parent >= 0 and parent not in kept:
            parent = PARENTS[parent]
        parents.append(kept.index(parent) if parent >= 0 else -1)
    reduced = SourceMotion(
        tuple(source.bones[i] for i in kept),
        np.array(parents),
        source.rest[kept],
        source.matrices[:, kept],
        30.0,
    )
    result = retarget(reduced, bundled_body)
    assert "spine2" not in result.bones
    np.testing.assert_allclose(result.motion.rotations[:, 16:20], waving.rotations[:, 16:20], atol=1e-9)


@pytest.mark.parametrize(
    ("rig", "spine", "played"),
    [
        ("Mixamo", ("Spine", "Spine1", "Spine2", "Spine3"), ("Spine", "Spine2", "Spine3")),
        ("Mixamo", ("Spine", "Spine1", "Spine2", "Spine3", "Spine4"), ("Spine", "Spine2", "Spine4")),
        ("Mixamo", ("Spine", "Spine1", "Spine2"), ("Spine", "Spine1", "Spine2")),
        ("Xsens BVH", ("Chest", "Chest2", "Chest3", "Chest4"), ("Chest", "Chest3", "Chest4")),
        ("Rokoko", ("Spine1", "Spine2", "Spine3", "Spine4"), ("Spine1", "Spine3", "Spine4")),
        ("Unreal", tuple(f"spine_0{i}" for i in range(1, 6)), ("spine_01", "spine_03", "spine_05")),
        ("Bandai-Namco", ("Spine", "Chest", "UpperChest"), ("Spine", "Chest", "UpperChest")),
    ],
)
@pytest.mark.parametrize("collars", ["on the spine", "on the neck"])
def test_the_bone_that_carries_neck_and_arms_moves_the_chest(bundled_body, rig, spine, played, collars):
    bone_map = next(bone_map for bone_map in bundled_bone_maps() if bone_map.name == rig)
    names = {joint: bone_map.joints.get(name, (f"no {name}",))[0] for joint, name in enumerate(JOINT_NAMES)}
    chest = JOINT_INDEX["spine3"]
    bones, parents, heads = [names[0], *spine], [-1, *range(len(spine))], list(bundled_body.joints[:1])
    heads += list(np.linspace(bundled_body.joints[3], bundled_body.joints[chest], len(spine)))
    where = {0: 0, chest: len(spine)}
    for joint in range(1, N_JOINTS):
        if not JOINT_NAMES[joint].startswith("spine"):
            parent = PARENTS[joint]
            if collars == "on the neck" and JOINT_NAMES[joint].endswith("collar"):
                parent = JOINT_INDEX["neck"]
            where[joint] = len(bones)
            bones.append(names[joint])
            parents.append(where[parent])
            heads.append(bundled_body.joints[joint])
    rest = np.tile(np.eye(4), (len(bones), 1, 1))
    rest[:, :3, 3] = heads
    bent = rest.copy()
    bend = TURN("x", 30, degrees=True).as_matrix()
    above = slice(len(spine), None)  # the last spine bone and all that it carries, legs apart
    bent[above, :3, :3] = bend
    bent[above, :3, 3] = (rest[above, :3, 3] - rest[len(spine), :3, 3]) @ bend.T + rest[len(spine), :3, 3]
    legs = [
        where[JOINT_INDEX[f"{side}_{part}"]] for side in SIDES for part in ("hip", "knee", "ankle", "foot")
    ]
    bent[legs] = rest[legs]
    source = SourceMotion(tuple(bones), np.array(parents), rest, np.stack([rest, bent]), 30.0)
    result = retarget(source, bundled_body)
    assert result.bone_map == rig
    assert tuple(result.bones[f"spine{number}"] for number in (1, 2, 3)) == played
    turns, _ = joint_transforms(bundled_body, result.motion)
    np.testing.assert_allclose(turns[1, chest], bend, atol=1e-9)
    np.testing.assert_allclose(turns[1, JOINT_INDEX["spine2"]], np.eye(3), atol=1e-9)


def test_a_bone_map_of_the_user_s_own_keeps_its_spine(bundled_body, waving):
    source = as_source(bundled_body, waving, arms_at(0))
    joints = {name: (bone.lower(),) for name, bone in zip(JOINT_NAMES, MIXAMO_NAMES, strict=True)}
    mine = BoneMap("mine", joints | {"spine2": ("spine",), "spine3": ("spine1",)})
    assert retarget(source, bundled_body, [mine]).bones["spine3"] == "Spine1"


def test_travel_in_centimetres_on_a_rig_in_metres_is_seen(bundled_body, waving):
    source = as_source(bundled_body, waving, arms_at(0))
    matrices = source.matrices.copy()
    bob = np.linspace(0, 0.08, waving.n_frames)
    matrices[..., 2, 3] += 100 * bob[:, None]
    travelling = SourceMotion(source.bones, source.parents, source.rest, matrices, source.rate)
    assert np.ptp(retarget(travelling, bundled_body).motion.pelvis[:, 2]) < 1


def test_an_unknown_rig_is_matched_by_its_structure(bundled_body, waving):
    known = as_source(bundled_body, waving, arms_at(0))
    odd = replace(known, bones=tuple(f"joint{i}" for i in range(24)))
    carried, expected = retarget(odd, bundled_body), retarget(known, bundled_body)
    assert carried.bone_map == BY_STRUCTURE
    assert {joint: odd.bones.index(bone) for joint, bone in carried.bones.items()} == {
        joint: known.bones.index(bone) for joint, bone in expected.bones.items()
    }
    np.testing.assert_allclose(carried.motion.rotations, expected.motion.rotations, atol=1e-9)


def test_a_rig_of_no_person_is_refused_with_its_bones_named(bundled_body, waving):
    source = as_source(bundled_body, waving, arms_at(0))
    star = replace(source, bones=tuple(f"joint{i}" for i in range(24)), parents=np.array([-1] + 23 * [0]))
    with pytest.raises(UnusableMotion, match=r"by name or by structure, for 13 needed joints.*joint1"):
        retarget(star, bundled_body)


vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 1e-3)


@pytest.mark.later
@settings(max_examples=60)
@given(vectors, vectors)
def test_the_smallest_rotation_turns_one_direction_to_the_other(a, b):
    rotation = smallest_rotation(a, b)
    np.testing.assert_allclose(rotation @ (a / np.linalg.norm(a)), b / np.linalg.norm(b), atol=1e-14)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1, abs=1e-14)


def test_opposite_directions_have_a_rotation_too():
    np.testing.assert_allclose(
        smallest_rotation(np.array([0, 0, 1.0]), np.array([0, 0, -2.0])) @ [0, 0, 1], [0, 0, -1], atol=1e-12
    )


def test_a_rest_pose_whose_shoulders_lie_on_each_other_is_no_body_s():
    joints = ("left_hip", "right_hip", "left_shoulder", "right_shoulder", "head")
    rest = dict(
        zip(
            (JOINT_INDEX[name] for name in joints),
            np.array([[1.0, 0, 0], [-1, 0, 0], [2, 0, 5], [-2, 0, 5], [0, 0, 7]]),
            strict=True,
        )
    )
    assert not is_crumpled(rest)
    rest[JOINT_INDEX["left_shoulder"]] = rest[JOINT_INDEX["right_shoulder"]] + 1e-4
    assert is_crumpled(rest)
    del rest[JOINT_INDEX["left_shoulder"]]
    assert not is_crumpled(rest)
    assert not is_crumpled({})
