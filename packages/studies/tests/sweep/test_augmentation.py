# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of motions: what must change and what must not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, MIRRORED_JOINTS, Body
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w_studies.sweep.augmentation import at_tempo, mirrored, scaled


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
