# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of a motion, under its own labels: in a mirror, at another speed, wider or narrower."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_NAMES, MIRRORED_JOINTS
from w2w.core.motion.motion import Motion

ACROSS = np.diag([-1.0, 1.0, 1.0])
"""Reflection in the plane between left and right of the T-pose, which faces -y."""


def mirrored(motion: Motion) -> Motion:
    """The motion seen in a mirror: what the left side did, the right side does."""
    rotations = ACROSS @ motion.rotations[:, list(MIRRORED_JOINTS)] @ ACROSS
    return replace(motion, rotations=rotations, pelvis=motion.pelvis @ ACROSS)


def at_tempo(motion: Motion, factor: float) -> Motion:
    """The same poses at another speed; 2 is twice as fast.

    The poses stay as they are and the frame rate changes, so nothing is interpolated.
    Speeds scale with the factor and accelerations with its square, falls included: far
    from 1 a jump no longer falls as bodies do.
    """
    return replace(motion, rate=motion.rate * factor)


def scaled(motion: Motion, factor: float, joints: Collection[str] = JOINT_NAMES[1:]) -> Motion:
    """Wider or narrower movements: angles of some joints from their mean rotation, multiplied by a factor.

    The pelvis's own rotation is kept, and so are heading and balance; its path about a straight line is
    scaled when both legs are, as smaller steps make a smaller bob. One side's limbs make the motion
    asymmetric.
    """
    rotations = motion.rotations.copy()
    for joint in (JOINT_NAMES.index(name) for name in joints):
        poses = Rotation.from_matrix(rotations[:, joint])
        mean = poses.mean()
        away = Rotation.from_rotvec(factor * (mean.inv() * poses).as_rotvec())
        rotations[:, joint] = (mean * away).as_matrix()
    pelvis = motion.pelvis
    if {"left_hip", "right_hip"} <= set(joints):
        time = np.linspace(-1.0, 1.0, len(pelvis))[:, None]
        slope = (time * pelvis).sum(axis=0) / max((time**2).sum(), 1e-12)
        line = pelvis.mean(axis=0) + time * slope  # least squares
        pelvis = line + factor * (pelvis - line)
    return replace(motion, rotations=rotations, pelvis=pelvis)
