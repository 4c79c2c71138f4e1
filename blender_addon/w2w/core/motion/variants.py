# SPDX-License-Identifier: GPL-3.0-or-later
"""The root path of motions that measured none: inertial motion capture finds it by dead reckoning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..filtering import butterworth
from .motion import Motion

ORDER = 3
"""Of the Butterworth filter, run forwards and backwards."""


def smoothed_root(motion: Motion, cutoff_hz: float) -> Motion:
    """The same motion with its root path low-passed, without delay; turns of the joints stay as they are.

    Suits inertial motion capture (Xsens, Perception Neuron, Rokoko). Its suits measure how segments turn, not
    where the body is: the root is hung on whichever foot is thought to stand and jumps by millimetres where
    that changes hands, which differentiating twice makes the largest acceleration of all. Optical motion
    capture measures the root; leave it alone.

    Parameters
    ----------
    motion : Motion
    cutoff_hz : float
        -3 dB, Hz; below half the frame rate.

    Raises
    ------
    ValueError
        If the cut-off is not between 0 and half the frame rate.
    """
    return replace(motion, pelvis=low_passed(motion.pelvis, motion.rate, cutoff_hz))


def low_passed(path: np.ndarray, rate: float, cutoff_hz: float) -> np.ndarray:
    """A path (T, 3) low-passed without delay, as `smoothed_root` does it."""
    return butterworth(path.T, rate, cutoff_hz, ORDER, zero_phase=True).T
