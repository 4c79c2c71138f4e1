# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations of a chain of two segments with a hinge between them, from the segments' directions.

A direction fixes two of a segment's three angles. The third, the twist, shows in the plane that an elbow or
a knee bends in: the better the more it is bent. If it is straight the twist follows its neighbours in
time and an anatomical prior: no twist but the one that the smallest rotation from the T-pose gives.
"""

import numpy as np

from ..rotations import smallest_rotation, turn_about, unit
from .paths import smooth

DIRECTION_NOISE = 0.1
"""Error of a segment's direction, radians: how fast a hinge's plane becomes certain as it bends."""

TWIST_PRIOR = 0.7
"""Standard deviation of the twist if nothing shows it, radians."""

TWIST_BAND_HZ = 1.0
"""Band that a twist known to `DIRECTION_NOISE` over sin(bend) = itself is smoothed to."""

Evidence = tuple[np.ndarray, float]
"""A hinge axis (T, 3) in the parent's frame, which shows a segment's twist, and its weight against a hinge of
flesh and bone, 1. The axis's length across the segment, the sine of the bend, is how sharply it shows."""


def swing_and_twist(
    rest: np.ndarray,
    hinge: np.ndarray,
    direction: np.ndarray,
    evidence: list[Evidence],
    limit: float,
    rate: float,
) -> np.ndarray:
    """Rotation of a segment in its parent's frame, shape (T, 3, 3).

    `rest` (3,) is the segment's direction in the T-pose and `hinge` (3,) the axis of the joint at its far end
    there, about which a positive turn bends it; `direction` (T, 3) is the segment's in the parent's frame. A
    segment without evidence does not show its twist; `limit` is the greatest one, radians.
    """
    axis = unit(direction)
    swing = smallest_rotation(rest, axis)
    if not evidence:
        return swing
    reference = swing @ unit(hinge - rest * (hinge @ rest) / (rest @ rest))
    across = np.cross(axis, reference)
    noise = DIRECTION_NOISE**2
    pull, weight = np.zeros(len(axis), dtype=complex), np.zeros(len(axis))
    for shown, trust in evidence:
        cosine, sine = ((shown * basis).sum(axis=1) for basis in (reference, across))
        square = cosine**2 + sine**2
        certain = trust * np.clip(square - noise, 0, None) / noise
        pull = pull + certain * (cosine + 1j * sine) / np.sqrt(np.maximum(square, 1e-12))
        weight = weight + certain
    prior = 1 / TWIST_PRIOR**2
    total = weight + prior
    target = (pull + prior) / total
    path = smooth(np.stack([target.real, target.imag], axis=1), total, rate, TWIST_BAND_HZ, order=2)
    twist = np.clip(np.arctan2(path[:, 1], path[:, 0]), -limit, limit)
    return turn_about(axis, twist) @ swing


def hinge_bend(
    rest: np.ndarray, hinge: np.ndarray, direction: np.ndarray, least: float, most: float, aside: float
) -> np.ndarray:
    """Rotation of a hinged segment in its parent's frame, within the joint's limits, shape (T, 3, 3).

    `rest` and `hinge` (3,) are the segment's direction and the hinge axis in the T-pose, `direction` (T, 3)
    is the segment's in the parent's frame. The bend is from `least` to `most`, at most `aside` out of the
    hinge's plane, radians.
    """
    along = unit(rest)
    axis = unit(hinge - along * (hinge @ along))
    ahead = np.cross(axis, along)
    direction = unit(direction)
    bend = np.arctan2(direction @ ahead, direction @ along)
    # beyond the hinge's dead point a bend reads as a large negative one
    bend = np.clip(np.where(bend < -np.pi / 2 - 0.5, bend + 2 * np.pi, bend), least, most)
    lean = np.clip(np.arcsin(np.clip(direction @ axis, -1, 1)), -aside, aside)
    plane = np.cos(bend)[:, None] * along + np.sin(bend)[:, None] * ahead
    limited = np.cos(lean)[:, None] * plane + np.sin(lean)[:, None] * axis
    turned = turn_about(np.broadcast_to(axis, plane.shape), bend)
    return smallest_rotation(plane, limited) @ turned


def cone_swing(rest: np.ndarray, direction: np.ndarray, widest: float) -> np.ndarray:
    """Smallest rotation from the T-pose's direction, no wider than a cone; shape (T, 3, 3).

    `rest` is (3,), `direction` (T, 3) in the parent's frame, `widest` half the cone's opening, radians.
    """
    along, direction = unit(rest), unit(direction)
    axis = unit(np.cross(along, direction))
    angle = np.arccos(np.clip(direction @ along, -1, 1))
    return turn_about(axis, np.minimum(angle, widest))
