# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion at another frame rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from ..filtering import count_resampled
from .motion import Motion


def at_rate(motion: Motion, rate: float) -> Motion:
    """The motion at another frame rate, along splines through its frames that bend smoothly."""
    if motion.rate == rate:
        return motion
    own = np.arange(motion.n_frames) / motion.rate
    times = np.arange(count_resampled(motion.n_frames, motion.rate, rate)) / rate
    times = np.minimum(times, own[-1])  # rounding
    rotations = np.stack(
        [
            RotationSpline(own, Rotation.from_matrix(motion.rotations[:, joint]))(times).as_matrix()
            for joint in range(motion.rotations.shape[1])
        ],
        axis=1,
    )
    return replace(motion, rotations=rotations, pelvis=CubicSpline(own, motion.pelvis)(times), rate=rate)
