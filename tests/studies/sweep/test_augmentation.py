# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of motions and recordings: what must change and what must not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from w2w.core.body.body import Body
from w2w.core.body.skeleton import JOINT_INDEX, JOINT_NAMES, MIRRORED_JOINTS
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.studies.sweep.augmentation import (
    Augmentation,
    at_tempo,
    mirrored,
    remounted,
    scaled,
    time_warped,
)


@pytest.fixture(scope="module")
def motion():
    """A walk of made-up smooth joint angles, turning and travelling; 4 s at 30 Hz."""
    rng = np.random.default_rng(3)
    time = np.arange(120) / 30.0
    waves = np.sin(2 * np.pi * (time[:, None] * rng.uniform(0.3, 1.2, 72) + rng.uniform(0, 1, 72)))
    angles = (waves * rng.uniform(0, 0.5, 72)).reshape(120, 24, 3)
    angles[:, 0, 2] = time
    pelvis = np.stack([0.1 * np.sin(time), -time, 0.9 + 0.03 * np.cos(6 * time)], axis=1)
    rotations = Rotation.from_rotvec(angles.reshape(-1, 3)).as_matrix().reshape(120, 24, 3, 3)
    return Motion(rotations, pelvis, 30.0, "walk", "anna", "walk_01")


def test_mirror_is_the_mirror_image_of_every_joint(motion):
    body = Body.bundled()
    symmetric = (body.joints + body.joints[list(MIRRORED_JOINTS)] * [-1, 1, 1]) / 2
    body = replace(body, joints=symmetric)
    _, positions = joint_transforms(body, motion)
    _, seen = joint_transforms(body, mirrored(motion))
    np.testing.assert_allclose(seen, positions[:, list(MIRRORED_JOINTS)] * [-1, 1, 1], atol=1e-9)


def test_mirroring_twice_gives_the_motion_back(motion):
    twice = mirrored(mirrored(motion))
    np.testing.assert_array_equal(twice.rotations, motion.rotations)
    np.testing.assert_array_equal(twice.pelvis, motion.pelvis)


@pytest.mark.parametrize(
    ("activity", "sided"),
    [("raise_up_left_hand", True), ("Kick Right", True), ("kick", False), ("leftover", False), ("", False)],
)
def test_an_activity_that_names_a_side_is_not_mirrored(motion, activity, sided):
    """Its mirror image is the other side's activity, and would be trained on under the wrong name."""
    labelled = motion.labelled(activity, "one", "clip")
    first, second = Augmentation.only(["mirror"], copies=2).motions(labelled, seed=3)
    shown = labelled if sided else mirrored(labelled)
    np.testing.assert_array_equal(first.rotations, shown.rotations)
    np.testing.assert_array_equal(second.rotations, labelled.rotations)


def test_tempo_scales_speed_and_the_square_of_it_acceleration(motion):
    body = Body.bundled()
    settings = Synthesis(rate_hz=60.0, cutoff_hz=None, gravity=(0.0, 0.0, 0.0))
    signals = []
    for factor in (1.0, 1.5):
        variant = at_tempo(motion, factor)
        rotations, positions = joint_transforms(body, variant)
        matrices = np.tile(np.eye(4), (motion.n_frames, 24, 1, 1))
        matrices[..., :3, :3], matrices[..., :3, 3] = rotations, positions
        slower = replace(settings, rate_hz=60.0 * factor)
        signals.append(synthesize(matrices, variant.rate, slower))
    np.testing.assert_allclose(signals[1].gyr, 1.5 * signals[0].gyr, atol=1e-4)
    np.testing.assert_allclose(signals[1].acc, 1.5**2 * signals[0].acc, atol=1e-3)


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 1.4])
def test_amplitude_scales_the_angle_about_the_mean_pose(factor):
    angle = 0.8 * np.sin(np.linspace(0, 2 * np.pi, 200, endpoint=False))
    rotations = np.tile(np.eye(3), (200, 24, 1, 1))
    resting = Rotation.from_euler("y", 0.6)
    knee = JOINT_INDEX["left_knee"]
    rotations[:, knee] = (resting * Rotation.from_rotvec(angle[:, None] * [1.0, 0, 0])).as_matrix()
    path = np.stack([0.2 * np.sin(8 * np.linspace(0, 6, 200)), -np.linspace(0, 3, 200), np.ones(200)], axis=1)
    motion = Motion(rotations, path, 30.0)
    result = scaled(motion, factor)
    expected = (resting * Rotation.from_rotvec(factor * angle[:, None] * [1.0, 0, 0])).as_matrix()
    np.testing.assert_allclose(result.rotations[:, knee], expected, atol=1e-6)
    np.testing.assert_allclose(result.pelvis[:, 1:], path[:, 1:], atol=1e-12)
    sway = np.polynomial.Polynomial.fit(np.arange(200), path[:, 0], 1)(np.arange(200))
    np.testing.assert_allclose(result.pelvis[:, 0], sway + factor * (path[:, 0] - sway), atol=1e-12)


def test_one_sided_amplitude_leaves_the_other_side_alone(motion):
    left = [name for name in JOINT_NAMES if name.startswith("left_")]
    limp = scaled(motion, 0.5, left)
    for joint, name in enumerate(JOINT_NAMES):
        same = np.allclose(limp.rotations[:, joint], motion.rotations[:, joint])
        assert same != (name in left)
    np.testing.assert_array_equal(limp.pelvis, motion.pelvis)


def test_time_warp_keeps_the_ends_the_order_and_the_poses(motion):
    warped = time_warped(motion, 0.3, np.random.default_rng(0))
    for kept in (0, -1):
        np.testing.assert_allclose(warped.rotations[kept], motion.rotations[kept], atol=1e-9)
        np.testing.assert_allclose(warped.pelvis[kept], motion.pelvis[kept], atol=1e-9)
    clock = -warped.pelvis[:, 1] * motion.rate
    steps = np.diff(clock)
    assert (steps > 0.7 / 1.3 - 1e-3).all()
    assert (steps < 1.3 / 0.7 + 1e-3).all()
    assert steps.std() > 0.05
    pelvis = Rotation.from_matrix(motion.rotations[:, 0])
    expected = Slerp(np.arange(motion.n_frames), pelvis)(clock).as_matrix()
    np.testing.assert_allclose(warped.rotations[:, 0], expected, atol=1e-4)


def test_remounting_is_one_fixed_rotation_a_sensor():
    rng = np.random.default_rng(1)
    acc, gyr = rng.normal(size=(2, 50, 300, 3)).astype(np.float32)
    one = ImuRecording(acc, gyr, 50.0, clip="c")
    turned = remounted(one, 20.0, np.random.default_rng(2))
    angles = []
    for sensor in range(0, 300, 3):
        both = np.concatenate([acc[:, sensor], gyr[:, sensor]])
        turned_both = np.concatenate([turned.acc[:, sensor], turned.gyr[:, sensor]])
        found, error = Rotation.align_vectors(turned_both, both)
        assert error < 1e-4
        angles.append(found.magnitude())
    assert np.degrees(np.sqrt(np.mean(np.square(angles)))) == pytest.approx(20.0, rel=0.2)


def test_variants_are_reproducible_differ_and_stay_in_the_clip(motion):
    plan = Augmentation(copies=3)
    first, again = (list(plan.motions(motion, seed=5)) for _ in range(2))
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a.rotations, b.rotations)
        assert a.rate == b.rate
        assert (a.clip, a.activity, a.subject) == ("walk_01", "walk", "anna")
    assert len({variant.rate for variant in first}) == 3


@pytest.mark.parametrize("switch", ["mirror", "tempo", "amplitude", "warp"])
def test_each_switch_alone_changes_the_motion_and_none_changes_nothing(motion, switch):
    off = {"copies": 1, "mirror": False, "tempo": 0.0, "amplitude": 0.0, "warp": 0.0}
    (untouched,) = Augmentation(**off).motions(motion, 0)
    np.testing.assert_array_equal(untouched.rotations, motion.rotations)
    (changed,) = Augmentation(**off | {switch: True if switch == "mirror" else 0.3}).motions(motion, 0)
    moved = not np.array_equal(changed.rotations, motion.rotations)
    assert moved or changed.rate != motion.rate


@pytest.mark.parametrize(
    ("parameter", "value"),
    [("copies", -1), ("tempo", -0.1), ("amplitude", 1.5), ("warp", 0.95), ("remount_deg", -1)],
)
def test_wrong_parameters_are_named(parameter, value):
    with pytest.raises(ValueError, match=parameter):
        Augmentation(**{parameter: value})
