# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's cloth in real time at any frame rate.

It knows none: a frame is its unit of time, and gravity is a thousandth of the scene's a frame
squared. So it keeps real time at the root of 1,000 frames per second, and elsewhere only where its
speed says so.
"""

from __future__ import annotations

import math

import numpy as np

REAL_TIME_RATE = math.sqrt(1000.0)
"""Frames per second at which cloth of speed 1 falls as things do."""

NUDGE = 1e-6


def real_time_speed(speed: float, rate: float, steps: int) -> float:
    """The speed that lets cloth keep time at a frame rate.

    Blender adds steps up in single precision until they fill the frame, and where rounding leaves
    them short by a hair it makes one more, a tenth of the gravity too much at 20 steps: such speeds
    are passed over.

    Parameters
    ----------
    speed : float
        Asked for by the user; 1 is real time.
    rate : float
        Frames per second.
    steps : int
        Of the simulation, each frame.
    """
    wanted = speed * REAL_TIME_RATE / rate
    nudged = wanted
    while _steps_made(nudged, steps) > steps:
        nudged += NUDGE * wanted
    return nudged


def _steps_made(speed: float, steps: int) -> int:
    """Steps that Blender makes of a frame, counted as it counts them."""
    frame = np.float32(speed)
    step = np.float32(1) / np.float32(steps) * frame
    done, count = np.float32(0), 0
    while done < frame:
        done += step
        count += 1
    return count
