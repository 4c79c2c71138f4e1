# SPDX-License-Identifier: GPL-3.0-or-later
"""The lever arm between a point whose path is known and an accelerometer, by least squares."""

import numpy as np


def lever_effects(spin: np.ndarray, spin_up: np.ndarray) -> np.ndarray:
    """What a unit of lever arm along each axis adds to the specific force, w' x r + w x (w x r).

    `spin`, `spin_up` (T, 3): angular velocity and acceleration in the sensor frame, rad/s and rad/s2.
    Returns (T, 3, 3): times an arm (3,), in metres, the difference in m/s2.
    """
    return np.stack(
        [np.cross(spin_up, axis) + np.cross(spin, np.cross(spin, axis)) for axis in np.eye(3)], axis=-1
    )


def fitted_arm(missing: np.ndarray, effects: np.ndarray) -> np.ndarray:
    """Lever arm (3,), m, that explains most of a missing specific force (T, 3)."""
    return np.linalg.lstsq(effects.reshape(-1, 3), missing.ravel(), rcond=None)[0]
