# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the ground is, what counts as upright, straight and absurd, and what stands in for missing bones."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS, PARENTS
from w2w.core.motion.believable import believed
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms, on_the_ground, skin, skinning_transforms
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.retargeting.retarget import rest_alignment, retarget

from .test_retarget import arms_at, as_source


def standing(body, heights):
    """The T-pose, lifted by so much in each frame."""
    rotations = np.tile(np.eye(3), (len(heights), N_JOINTS, 1, 1))
    pelvis = np.tile(body.joints[0], (len(heights), 1))
    pelvis[:, 2] += heights
    return Motion(rotations, pelvis, 30.0)


def lowest(body, motion):
    return skin(body, skinning_transforms(body, motion))[..., 2].min(axis=1)


@pytest.mark.parametrize("lift", [-3.0, 0.0, 0.7])
def test_the_ground_is_where_the_soles_stand_however_long_the_body_is_in_the_air(bundled_body, lift):
    """In the air in nine frames of ten; one frame in a hundred far too low does not lift all others."""
    heights = np.full(100, 0.6)
    heights[20:30], heights[50] = 0.0, -0.9
    found = lowest(bundled_body, on_the_ground(bundled_body, standing(bundled_body, lift + heights)))
    np.testing.assert_allclose(found, heights, atol=0.003)


def test_the_ground_is_felt_by_every_part_of_the_body(bundled_body):
    """Lying, kneeling, on one hand: the lowest vertex of all stands at zero within a finger."""
    rotations = np.tile(np.eye(3), (30, N_JOINTS, 1, 1))
    rotations[:, 0] = Rotation.random(30, random_state=5).as_matrix()
    for seed, joint in enumerate(("left_hip", "right_shoulder", "left_knee")):
        turned = Rotation.random(30, random_state=seed).as_matrix()
        rotations[:, JOINT_INDEX[joint]] = turned
    for turns in rotations:
        motion = Motion(np.tile(turns, (4, 1, 1, 1)), np.tile([0, 0, 5.0], (4, 1)), 30.0)
        found = lowest(bundled_body, on_the_ground(bundled_body, motion))
        np.testing.assert_allclose(found, 0, atol=0.03)


def test_the_midpoint_of_the_hips_is_kept_not_the_pelvis(bundled_body, waving):
    """A body whose pelvis lies elsewhere between its hips has its hips where the source's are."""
    source = as_source(bundled_body, waving, arms_at(0))
    motion = retarget(source, bundled_body).motion
    _, heads = joint_transforms(bundled_body, motion)
    hips = [JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]]
    theirs = source.matrices[:, hips][..., :3, 3].mean(axis=1)
    ours = heads[:, hips].mean(axis=1)
    np.testing.assert_allclose((ours - theirs)[:, :2], 0, atol=1e-9)
    np.testing.assert_allclose(np.ptp((ours - theirs)[:, 2]), 0, atol=1e-9)


def test_the_scale_is_that_of_the_legs_that_move(bundled_body, waving):
    """A rest pose in another unit than the frames, as some files have."""
    source = as_source(bundled_body, waving, arms_at(0), scale=100.0)
    source.rest[:, :3, 3] /= 100
    result = retarget(source, bundled_body)
    assert result.scale == pytest.approx(0.01)
    np.testing.assert_allclose(result.motion.rotations, waving.rotations, atol=1e-9)
    np.testing.assert_allclose(np.ptp(result.motion.pelvis - waving.pelvis, axis=0), 0, atol=1e-9)


def test_travel_in_centimetres_comes_out_in_metres(bundled_body, waving):
    """Limbs in metres, the same path a hundred times as long."""
    source = as_source(bundled_body, waving, arms_at(0))
    hips = [JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]]
    path = source.matrices[:, hips][..., :3, 3].mean(axis=1)
    source.matrices[..., :3, 3] += 99 * path[:, None]
    _, heads = joint_transforms(bundled_body, retarget(source, bundled_body).motion)
    ours = heads[:, hips].mean(axis=1)
    np.testing.assert_allclose(ours - ours[0], path - path[0], atol=1e-9)


def test_a_fall_in_millimetres_on_a_rig_in_centimetres_is_not_taken_for_one_in_metres(bundled_body, waving):
    """A body that lies down sinks by a whole leg: ten times of that is no hundred."""
    turns = waving.rotations.copy()
    down = -np.pi / 2 * np.linspace(0, 1, len(turns))
    turns[:, 0] = Rotation.from_rotvec(np.outer(down, [1, 0, 0])).as_matrix()
    falling = Motion(turns, 0 * waving.pelvis, waving.rate)
    falling.pelvis[:, 2] = -joint_transforms(bundled_body, falling)[1][:, :, 2].min(axis=1)
    source = as_source(bundled_body, falling, arms_at(0))
    path = source.matrices[:, 0, :3, 3].copy()
    source.matrices[..., :3, 3] += 9 * path[:, None]
    found = retarget(source, bundled_body).motion
    np.testing.assert_allclose(np.ptp(found.pelvis[:, 2]), 10 * np.ptp(falling.pelvis[:, 2]), rtol=0.1)
    with pytest.raises(UnusableMotion, match=r"divide it by 10 or 12$"):
        believed(bundled_body, found)


def rest_of(body, turns):
    """Joint positions of a body with some joints turned, as a rest pose; and the turn of each part."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    for joint, turn in turns.items():
        rotations[0, JOINT_INDEX[joint]] = Rotation.from_euler(*turn, degrees=True).as_matrix()
    worlds, heads = joint_transforms(body, Motion(rotations, body.joints[:1], 1.0))
    return dict(enumerate(heads[0])), worlds[0]


def angle(a, b):
    return np.degrees(Rotation.from_matrix(a.T @ b).magnitude())


@pytest.mark.parametrize(("lean", "turned"), [(0, 0), (15, 0), (30, 30), (75, 90), (90, 90), (-95, -90)])
def test_a_trunk_that_leans_a_little_stands_along_an_axis(bundled_body, lean, turned):
    """Within 20 degrees of an axis that is the body's up, as bind poses may have y up; else the trunk is."""
    rest, _ = rest_of(bundled_body, {"pelvis": ("x", lean)})
    expected = Rotation.from_euler("x", turned, degrees=True).as_matrix()
    assert angle(rest_alignment(bundled_body, rest)[0], expected) < 1e-6


@pytest.mark.parametrize(("bend", "flat"), [(0, True), (20, True), (35, False), (90, False)])
def test_a_foot_under_an_upright_shank_is_flat_and_on_a_bent_leg_it_is_not(bundled_body, bend, flat):
    """A rest pose with one knee bent backwards and the foot square to the shank."""
    rest, _ = rest_of(bundled_body, {"left_knee": ("x", bend)})
    found = rest_alignment(bundled_body, rest)
    knee, ankle, toe = (JOINT_INDEX[f"left_{name}"] for name in ("knee", "ankle", "foot"))
    tilt = np.degrees(np.arccos(found[ankle][2, 2]))
    assert tilt == pytest.approx(0 if flat else bend, abs=1e-6 if flat else 3)
    for start, end in [(knee, ankle)] + [(ankle, toe)] * (not flat):
        theirs = rest[end] - rest[start]
        ours = found[start] @ (bundled_body.joints[end] - bundled_body.joints[start])
        np.testing.assert_allclose(np.cross(ours, theirs), 0, atol=1e-9)
        assert ours @ theirs > 0


def test_a_foot_that_points_outwards_is_turned_out_not_up(bundled_body):
    rest, _ = rest_of(bundled_body, {"left_ankle": ("z", 25)})
    toe, ankle = JOINT_INDEX["left_foot"], JOINT_INDEX["left_ankle"]
    rest[toe] = rest[toe] + [0, 0, 0.06]  # a toe joint higher than the body's: no pitch
    found = rest_alignment(bundled_body, rest)[ankle]
    assert angle(found, Rotation.from_euler("z", 25, degrees=True).as_matrix()) < 1e-6


def test_a_missing_bone_keeps_what_its_parent_s_rest_pose_had_against_it(bundled_body, waving):
    """A foot goes on as its ankle does, a collar as the chest; all else is as if they were there."""
    lowered = arms_at(70)
    source = as_source(bundled_body, waving, lowered)
    kept = [i for i in range(N_JOINTS) if i not in (JOINT_INDEX["left_foot"], JOINT_INDEX["right_collar"])]
    position = {old: new for new, old in enumerate(kept)}
    parents = []
    for joint in kept:
        parent = PARENTS[joint]
        while parent >= 0 and parent not in position:
            parent = PARENTS[parent]
        parents.append(position.get(parent, -1))
    names = tuple(source.bones[i] for i in kept)
    reduced = SourceMotion(names, np.array(parents), source.rest[kept], source.matrices[:, kept], 30.0)
    result = retarget(reduced, bundled_body)
    turns, _ = joint_transforms(bundled_body, result.motion)
    expected, _ = joint_transforms(bundled_body, waving)
    for joint in range(N_JOINTS):
        if joint not in (JOINT_INDEX["left_foot"], JOINT_INDEX["right_collar"]):
            np.testing.assert_allclose(turns[:, joint], expected[:, joint], atol=1e-9)
    for joint in (JOINT_INDEX["left_foot"], JOINT_INDEX["right_collar"]):
        np.testing.assert_allclose(turns[:, joint], turns[:, PARENTS[joint]], atol=1e-9)
