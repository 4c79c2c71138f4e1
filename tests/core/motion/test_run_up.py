"""Before a clip begins, cloth is given time: the T-pose, the first pose, and the clip's own speed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.motion.run_up import RUN_UP_S, SETTLE_S, cloth_rate, reached_back, with_run_up


@pytest.mark.parametrize(
    ("rate", "simulated"), [(30, 60), (24, 72), (60, 60), (99, 99), (100, 50), (120, 60), (240, 60)]
)
def test_cloth_has_a_whole_part_or_multiple_of_the_clips_rate(rate, simulated):
    assert cloth_rate(rate) == pytest.approx(simulated)


def test_the_run_up_begins_in_the_t_pose_turned_as_the_clip(waving):
    moved, _ = with_run_up(waving)
    np.testing.assert_allclose(moved.rotations[0, 1:], np.broadcast_to(np.eye(3), (23, 3, 3)), atol=1e-9)
    turn = Rotation.from_matrix(waving.rotations[0, 0].T @ moved.rotations[0, 0]).magnitude()
    assert turn < 0.5


def test_the_clip_follows_unchanged_but_for_its_place(waving):
    moved, before = with_run_up(waving)
    own = moved.rotations[before::2]
    np.testing.assert_allclose(own, waving.rotations[: len(own)], atol=1e-9)
    way = moved.pelvis[before::2] - waving.pelvis[: len(own)]
    np.testing.assert_allclose(way, np.broadcast_to(way[0], way.shape), atol=1e-9)
    assert way[0, 2] == pytest.approx(0, abs=1e-12)


def test_no_joint_jumps_where_the_clip_begins(waving):
    moved, before = with_run_up(waving)
    turns = np.swapaxes(moved.rotations[:-1], -1, -2) @ moved.rotations[1:]
    speed = Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(-1, 24, 3) * moved.rate
    velocity = np.diff(moved.pelvis, axis=0) * moved.rate
    around = slice(before - 2, before + 1)
    assert np.abs(np.diff(speed[around], axis=0)).max() < 0.1 * np.abs(speed).max()
    assert np.abs(np.diff(velocity[around], axis=0)).max() < 0.1 * np.abs(velocity).max()


def test_the_body_stands_still_while_the_cloth_settles(waving):
    moved, before = with_run_up(waving)
    still = np.abs(np.diff(moved.rotations[:before], axis=0)).max(axis=(1, 2, 3)) == 0
    assert still.sum() == round(SETTLE_S * moved.rate) > 20


@pytest.mark.parametrize("reach", [0.5, 0.25, 0.125])
def test_a_shorter_reach_waits_nearer_to_the_first_pose_and_no_less_long(waving, reach):
    (usual, before), (moved, own) = with_run_up(waving), with_run_up(waving, reach)
    assert own == before
    np.testing.assert_allclose(moved.rotations[before:], usual.rotations[before:], atol=1e-9)
    waits = before - round(reach * RUN_UP_S * moved.rate) - 1
    np.testing.assert_array_equal(moved.rotations[waits], moved.rotations[waits - 5])
    angles = [
        Rotation.from_matrix(one.rotations[waits if one is moved else before - 25].swapaxes(-1, -2) @ first)
        for one, first in ((moved, moved.rotations[before]), (usual, usual.rotations[before]))
    ]
    short, whole = (angle.magnitude() for angle in angles)
    np.testing.assert_allclose(short, reach * whole, atol=1e-6)
    turns = np.swapaxes(moved.rotations[waits:before], -1, -2) @ moved.rotations[waits + 1 : before + 1]
    speed = Rotation.from_matrix(turns.reshape(-1, 3, 3)).magnitude().reshape(turns.shape[:2])
    assert (np.diff(speed, axis=0) > -1e-6).all()


def test_the_poses_looked_at_are_those_of_the_run_up(waving):
    moved, before = with_run_up(waving, 0.5)
    poses = reached_back(waving, 0.5)
    np.testing.assert_allclose(poses.rotations[0], moved.rotations[before - 13], atol=1e-9)
    np.testing.assert_allclose(poses.rotations[2], waving.rotations[0], atol=1e-9)


def test_a_glitch_in_the_first_frame_does_not_send_the_run_up_far_away(waving):
    pelvis = waving.pelvis.copy()
    pelvis[0] += 50
    moved, before = with_run_up(replace(waving, pelvis=pelvis))
    assert np.linalg.norm(moved.pelvis[0] - moved.pelvis[before]) < 1


def test_the_simulation_ends_no_earlier_than_the_clip(waving):
    for rate in (100.0, 110.0, 170.0):
        clip = replace(waving, rate=rate)
        moved, before = with_run_up(clip)
        assert (moved.n_frames - before - 1) / moved.rate >= clip.duration - 1e-9
