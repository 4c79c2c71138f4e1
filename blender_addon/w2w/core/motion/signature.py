# SPDX-License-Identifier: GPL-3.0-or-later
"""Signatures by which motions are compared: smoothed poses, independent of body and heading."""

import numpy as np

from ..body.body import JOINT_INDEX, MIRRORED_JOINTS
from .motion import Motion

JOINTS = tuple(
    JOINT_INDEX[name]
    for name in (
        "left_hip", "right_hip", "left_knee", "right_knee", "spine2",
        "left_shoulder", "right_shoulder", "left_elbow", "right_elbow",
        "neck", "head", "left_wrist", "right_wrist", "left_ankle", "right_ankle",
    )
)  # fmt: skip

WIDTH = 6 * len(JOINTS)
"""Numbers of a pose: two columns of each joint's rotation."""

RATE = 20.0
"""Poses of a signature per second."""

SMOOTHED = 0.07
"""Standard deviation of the Gaussian that smooths poses, seconds: it takes out noise."""

SIGNS = np.array([-1.0, 1.0, 1.0])[:, None] * np.array([-1.0, 1.0])
"""Signs of A R A with A = diag(-1, 1, 1), on the first two columns of R."""


def motion_signature(motion: Motion) -> np.ndarray:
    """Smoothed poses at `RATE`, independent of body and heading, shape (n * WIDTH,), float16.

    A line is fitted to the frames around each moment, so the ends of a cut clip are as they are inside the
    whole.
    """
    last = motion.n_frames - 1
    poses = motion.rotations[:, list(JOINTS)][..., :2].reshape(motion.n_frames, WIDTH)
    times = np.arange(int(motion.duration * RATE + 1e-6) + 1) / RATE * motion.rate
    reach = int(np.ceil(2.5 * SMOOTHED * motion.rate))
    frames = np.round(times).astype(int)[:, None] + np.arange(-reach, reach + 1)
    away = frames - times[:, None]
    weights = np.exp(-0.5 * (away / (SMOOTHED * motion.rate)) ** 2) * ((frames >= 0) & (frames <= last))
    total, first, second = ((weights * away**power).sum(axis=1) for power in range(3))
    spread = total * second - first**2
    line = weights * (second[:, None] - first[:, None] * away)
    weights = np.where(
        spread[:, None] > 1e-9, line / np.maximum(spread, 1e-9)[:, None], weights / total[:, None]
    )
    signature = np.zeros((len(times), WIDTH))
    for near, weight in zip(frames.clip(0, last).T, weights.T, strict=True):
        signature += weight[:, None] * poses[near]
    return signature.astype(np.float16).ravel()


def mirrored_poses(poses: np.ndarray) -> np.ndarray:
    """Poses (n, WIDTH) with left and right exchanged."""
    turns = poses.reshape(len(poses), len(JOINTS), 3, 2)
    partner = [JOINTS.index(MIRRORED_JOINTS[joint]) for joint in JOINTS]
    return (turns[:, partner] * SIGNS.astype(poses.dtype)).reshape(len(poses), WIDTH)
