# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions at another frame rate, or with their root path low-passed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from ..filtering import butterworth, count_resampled
from .motion import Motion

ORDER = 3
"""Of the Butterworth filter, run forwards and backwards."""


def smoothed_root(motion: Motion, cutoff_hz: float) -> Motion:
    """The same motion with its root path low-passed, without delay; turns of the joints stay as they are.

    Suits inertial motion capture (Xsens, Perception Neuron, Rokoko). Its suits measure how segments turn, not
    where the body is: the root is hung on whichever foot is thought to stand and jumps by millimetres where
    that changes hands, which differentiating twice makes the largest acceleration of all. Optical motion
    capture measures the root; leave it alone.

    The cut-off (-3 dB) lies between 0 and half the frame rate, or a ValueError is raised.
    """
    return replace(motion, pelvis=low_passed(motion.pelvis, motion.rate, cutoff_hz))


def low_passed(path: np.ndarray, rate: float, cutoff_hz: float) -> np.ndarray:
    """A path (T, 3) low-passed without delay, as `smoothed_root` does it."""
    return butterworth(path.T, rate, cutoff_hz, ORDER, zero_phase=True).T


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
