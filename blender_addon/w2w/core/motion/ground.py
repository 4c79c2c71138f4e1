# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the ground is under a motion."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from ..body.body import Body
from .motion import Motion
from .skinning import skin, skinning_transforms

SAMPLE = 15
"""Every fifteenth vertex is enough to find the lowest point of the body."""

PERCENTILE = 2.0
"""The body's lowest point is above the ground in all but this share of the frames."""

SUNK, HIGH = 0.1, 0.3
"""Metres by which a source sinks that is lower between its ends than at both; one by more came down."""

HELD_S, STEADY = 0.1, 0.03
"""Seconds at either end in which the lowest point of a body that stands rises or falls by less (m)."""

IN_PLACE = 0.5
"""Metres that a pelvis moves sideways at most in a clip that sinks: further down may be a step."""

RAMP_S = 0.05
"""Seconds in which a sinking body is lifted before it would be below the ground."""


def on_the_ground(body: Body, motion: Motion) -> Motion:
    """The same motion lifted or lowered as a whole until the body touches z = 0.

    One whose source sinks between its ends is level with its ends, and lifted by itself where it sinks.
    """
    heights = skinning_transforms(body, motion)[:, :, 2:]
    lowest = skin(body, heights, slice(None, None, SAMPLE))[:, :, 0].min(axis=1)
    pelvis = motion.pelvis.copy()
    ground = np.percentile(lowest, PERCENTILE)
    level = _level_of_ends(lowest, motion)
    if SUNK < level - ground < HIGH:
        pelvis[:, 2] += _lift(level - lowest, motion.rate)
        ground = level
    pelvis[:, 2] -= ground
    return replace(motion, pelvis=pelvis)


def _level_of_ends(lowest: np.ndarray, motion: Motion) -> float:
    """Height of a body in place that is steady at its ends, -inf of any other, by its lowest points (T,)."""
    held = max(round(HELD_S * motion.rate), 2)
    ends = lowest[:held], lowest[-held:]
    levels = [float(np.median(end)) for end in ends]
    steady = all(np.ptp(end) < STEADY for end in ends) and abs(levels[0] - levels[1]) < SUNK / 2
    in_place = np.linalg.norm(motion.pelvis[:, :2] - motion.pelvis[0, :2], axis=1).max() < IN_PLACE
    return min(levels) if steady and in_place else -np.inf


def _lift(depth: np.ndarray, rate: float) -> np.ndarray:
    """Smooth heights (T,) that are nowhere less than the depths (T,) below the ground, metres."""
    half = round(RAMP_S * rate)
    highest = maximum_filter1d(np.maximum(depth, 0.0), 4 * half + 1)
    return uniform_filter1d(uniform_filter1d(highest, 2 * half + 1), 2 * half + 1)
