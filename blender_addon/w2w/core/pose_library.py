# SPDX-License-Identifier: GPL-3.0-or-later
"""Random poses within human ranges of motion, to see what posing does to a body's surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from .motion import Motion
from .skeleton import JOINT_NAMES, N_JOINTS

RANGES: dict[str, tuple[tuple[float, float], ...]] = {
    "pelvis": ((0, 0), (0, 0), (0, 0)),
    "spine1": ((-5, 30), (-12, 12), (-12, 12)),
    "spine2": ((-5, 20), (-10, 10), (-15, 15)),
    "spine3": ((-5, 15), (-10, 10), (-15, 15)),
    "neck": ((-25, 25), (-20, 20), (-35, 35)),
    "head": ((-20, 20), (-15, 15), (-30, 30)),
    "hip": ((-110, 25), (-45, 15), (-30, 30)),
    "knee": ((0, 130), (0, 0), (-10, 10)),
    "ankle": ((-25, 40), (-15, 15), (-10, 10)),
    "foot": ((-30, 15), (0, 0), (0, 0)),
    "collar": ((-5, 5), (-25, 10), (-15, 15)),
    "shoulder": ((-50, 50), (-60, 80), (-110, 30)),
    "elbow": ((-70, 70), (0, 0), (-140, 0)),
    "wrist": ((0, 0), (-60, 60), (-25, 25)),
    "hand": ((0, 0), (0, 60), (0, 0)),
}
"""Least and largest angle (degrees) about the fixed x, y and z axes of the T-pose, for the left side.

About the active ranges of healthy adults (American Academy of Orthopaedic Surgeons, Joint
Motion, 1965), measured from the T-pose: x flexes hips (-) and knees (+), y lowers the arm (+),
z brings it forward and flexes the elbow (-).
"""


def random_poses(n: int, seed: int) -> Motion:
    """Poses whose joint angles are drawn evenly and independently from `RANGES`.

    Parameters
    ----------
    n : int
        Number of poses.
    seed : int

    Returns
    -------
    Motion
        One pose a frame, the pelvis at the origin; the frame rate means nothing.
    """
    rng = np.random.default_rng(seed)
    rotations = np.empty((n, N_JOINTS, 3, 3))
    for joint, name in enumerate(JOINT_NAMES):
        low, high = np.transpose(RANGES[name.split("_")[-1]])
        angles = rng.uniform(low, high, size=(n, 3))
        if name.startswith("right_"):
            angles *= (1, -1, -1)
        rotations[:, joint] = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    return Motion(rotations, np.zeros((n, 3)), rate=1)
