# SPDX-License-Identifier: GPL-3.0-or-later
"""Two bones and the hinge between them: how far they reach, and where they point to reach a target."""

import numpy as np


def reach(first: float, second: float, bend: np.ndarray | float) -> np.ndarray | float:
    """Distance between the ends of two bones whose joint is bent by `bend` (0 is straight)."""
    return np.sqrt(first**2 + second**2 + 2.0 * first * second * np.cos(bend))


def two_bones(
    target: np.ndarray,
    pole: np.ndarray,
    first: float,
    second: float,
    along: tuple[float, float, float],
    hinge: tuple[float, float, float],
) -> tuple[np.ndarray, np.ndarray]:
    """Analytic inverse kinematics of two bones and the hinge between them.

    `target` (T, 3): end of the second bone relative to the start of the first, metres, within reach.
    `pole` (T, 3): the middle joint points to this side.
    `first`, `second`: lengths, metres.
    `along`, `hinge`: in the rest pose: direction of both bones, and the axis about which the second bends;
    unit vectors at right angles.
    Returns (T, 3, 3): world rotation of the first and the second bone relative to the rest pose.
    """
    distance = np.linalg.norm(target, axis=1, keepdims=True)
    direction = target / distance
    side = pole - np.sum(pole * direction, axis=1, keepdims=True) * direction
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    cosine = (first**2 + distance**2 - second**2) / (2 * first * distance)
    middle = first * (cosine * direction + np.sqrt(1 - cosine**2) * side)
    axis = np.cross(side, direction)
    rest = _frame(np.array(along), np.array(hinge)).T
    return _frame(middle / first, axis) @ rest, _frame((distance * direction - middle) / second, axis) @ rest


def _frame(along: np.ndarray, hinge: np.ndarray) -> np.ndarray:
    return np.stack([along, hinge, np.cross(along, hinge)], axis=-1)
