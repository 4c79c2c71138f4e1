# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints of any BVH are where its channels, applied one by one, put them."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.bvh import as_it_stands, read_bvh
from w2w.core.readers.bvh_text import read_bvh_text

from ...made_bvh import MadeJoint, bvh_text, draw_joints, draw_values, true_poses

TURNS = ("Zrotation", "Xrotation", "Yrotation")
SHIFTS = ("Xposition", "Yposition", "Zposition")


def read(path, text):
    path.write_text(text)
    return as_it_stands(read_bvh_text(path), path.stem)


@pytest.mark.later
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 12))
def test_any_tree_any_channels_in_any_order(tmp_path_factory, seed, count):
    rng = np.random.default_rng(seed)
    joints = draw_joints(rng, count, whole=False)
    values = draw_values(rng, joints, 5)
    if not values.shape[1]:
        return
    found = read(tmp_path_factory.getbasetemp() / "any.bvh", bvh_text(joints, values))
    turns, places = true_poses(joints, values)
    np.testing.assert_array_equal(found.parents, [joint.parent for joint in joints])
    np.testing.assert_allclose(found.matrices[..., :3, :3], turns, atol=1e-12)
    np.testing.assert_allclose(found.matrices[..., :3, 3], places, atol=1e-9)
    np.testing.assert_array_equal(found.matrices[..., 3, :], np.broadcast_to([0, 0, 0, 1], (5, count, 4)))
    assert found.rate == pytest.approx(60, rel=1e-6)


def test_at_rest_joints_lie_at_their_offsets_unturned(tmp_path):
    joints = draw_joints(np.random.default_rng(3), 8, whole=False)
    still = [MadeJoint(joint.parent, joint.offset, ()) for joint in joints]
    found = read(tmp_path / "a.bvh", bvh_text(joints, draw_values(np.random.default_rng(4), joints, 4)))
    turns, places = true_poses(still, np.zeros((1, 0)))
    np.testing.assert_allclose(found.rest[:, :3, :3], turns[0], atol=0)
    np.testing.assert_allclose(found.rest[:, :3, 3], places[0], atol=1e-9)


def test_a_joint_without_channels_is_fixed_and_scales_are_left_out(tmp_path):
    joints = [
        MadeJoint(-1, (0, 0, 0), (*SHIFTS, *TURNS)),
        MadeJoint(0, (1, 2, 3), ()),
        MadeJoint(1, (1, 0, 0), ("Xscale", *TURNS)),
    ]
    values = draw_values(np.random.default_rng(0), joints, 5)
    text = bvh_text(joints, values)
    found = read(tmp_path / "a.bvh", text)
    without = [*joints[:2], MadeJoint(1, (1, 0, 0), TURNS)]
    turns, places = true_poses(without, np.delete(values, 6, axis=1))
    np.testing.assert_allclose(found.matrices[..., :3, :3], turns, atol=1e-12)
    np.testing.assert_allclose(found.matrices[..., :3, 3], places, atol=1e-9)
    unsaid = read(tmp_path / "b.bvh", text.replace("CHANNELS 0\n", ""))
    np.testing.assert_array_equal(unsaid.matrices, found.matrices)


def test_two_trees_are_two_people_and_a_prop_is_none(tmp_path):
    root, limb = MadeJoint(-1, (0, 0, 0), (*SHIFTS, *TURNS)), ("Xrotation",)
    person = [root, *(MadeJoint(parent, (0, 1, 0), limb) for parent in range(4))]
    other = [root, *(MadeJoint(5 + parent, (0, 1, 0), limb) for parent in range(4))]
    for joints, people in ((person, 1), ([*person, *other], 2), ([*person, root], 1)):
        values = draw_values(np.random.default_rng(1), joints, 5)
        assert read(tmp_path / "a.bvh", bvh_text(joints, values)).people == people


@pytest.mark.parametrize(
    ("frames", "reason"),
    [
        (0, "a pose, not a motion: 0 frames in 'sitting'"),
        (1, "1 frame in"),
        (9, "nothing moves over the 9 frames of 'sitting'"),
    ],
)
def test_what_does_not_move_is_no_motion(tmp_path, frames, reason):
    joints = draw_joints(np.random.default_rng(5), 6, whole=True)
    values = np.repeat(draw_values(np.random.default_rng(6), joints, 1), frames, axis=0)
    (tmp_path / "sitting.bvh").write_text(bvh_text(joints, values))
    with pytest.raises(UnusableMotion, match=reason):
        read_bvh(tmp_path / "sitting.bvh")
