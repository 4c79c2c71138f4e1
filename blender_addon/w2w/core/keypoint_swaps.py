# SPDX-License-Identifier: GPL-3.0-or-later
"""Left and right mixed up by a pose estimator: in some frames, or throughout."""

from __future__ import annotations

import numpy as np

from .joint_sets import SIDES, mirrored

LEGS = ("hip", "knee", "ankle", "toe")
ARMS = ("shoulder", "elbow", "wrist", "hand", "thumb side", "little finger side")

SWAP_COST = 1e-4
"""Cost of calling a frame swapped, as part of the squared size of the body: decides ties only."""

KNEES_SAY = 0.04
"""Knees that lie on average this far, in thigh lengths, in front of or behind the line from hip to ankle
show which way the person faces."""


def undo_swaps(points: dict[str, np.ndarray], size: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Undo frames in which the arms or the legs changed sides.

    Of all ways to call each frame swapped or not, the one along which the joints move least is taken
    (Viterbi's algorithm), for arms and legs apart; what most frames say is right.

    Parameters
    ----------
    points : dict of str to ndarray, shape (T, 3)
        Landmark -> path; NaN where not seen.
    size : float
        Length of the trunk, in their unit.

    Returns
    -------
    points : dict of str to ndarray
    swapped : ndarray of bool, shape (T, 2)
        Frames in which arms, legs were swapped.
    """
    points = dict(points)
    swapped = []
    for parts in (ARMS, LEGS):
        names = [
            f"left {part}" for part in parts if all(np.isfinite(points[f"{s} {part}"]).any() for s in SIDES)
        ]
        left = np.stack([points[name] for name in names], axis=1)
        right = np.stack([points[mirrored(name)] for name in names], axis=1)
        states = _smoothest(left, right, SWAP_COST * size**2)
        if states.mean() > 0.5:
            states = ~states
        for index, name in enumerate(names):
            points[name] = np.where(states[:, None], right[:, index], left[:, index])
            points[mirrored(name)] = np.where(states[:, None], left[:, index], right[:, index])
        swapped.append(states)
    return points, np.stack(swapped, axis=1)


def sides_are_exchanged(points: dict[str, np.ndarray]) -> bool:
    """Whether left and right are called the wrong way round throughout.

    Knees bend forwards and toes and noses point there; forward is where up and the left hip say it is.

    Parameters
    ----------
    points : dict of str to ndarray, shape (T, 3)
        Swaps of single frames undone.
    """
    left = points["left hip"] - points["right hip"]
    middle = (points["left hip"] + points["right hip"]) / 2
    up = (points["left shoulder"] + points["right shoulder"]) / 2 - middle
    forward = np.cross(left, up)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    evidence = []
    for side in SIDES:
        hip, knee, ankle = (points[f"{side} {part}"] for part in LEGS[:3])
        thigh = np.linalg.norm(knee - hip, axis=1)
        along = np.einsum("ta,ta->t", knee - hip, ankle - hip) / np.einsum(
            "ta,ta->t", ankle - hip, ankle - hip
        )
        offset = knee - hip - along[:, None] * (ankle - hip)
        evidence.append(np.einsum("ta,ta->t", offset, forward) / thigh)
        toe = points[f"{side} toe"]
        if np.isfinite(toe).any():
            evidence.append(np.einsum("ta,ta->t", toe - ankle, forward) / thigh)
    if np.isfinite(points["face"]).any() and np.isfinite(points["head"]).any():
        evidence.append(np.einsum("ta,ta->t", points["face"] - points["head"], forward) / np.nanmedian(thigh))
    seen = np.concatenate([values[np.isfinite(values)] for values in evidence])
    return len(seen) > 0 and float(seen.mean()) < -KNEES_SAY


def exchanged(points: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same paths with left and right called the other way round."""
    return {name: points[mirrored(name)] for name in points}


def _smoothest(left: np.ndarray, right: np.ndarray, swap_cost: float) -> np.ndarray:
    """Frames in which left and right (T, L, 3) are to be exchanged; shape (T,), bool."""
    left, right = (_held(values) for values in (left, right))
    step = lambda a, b: ((b[1:] - a[:-1]) ** 2).sum(axis=(1, 2))  # noqa: E731
    stay = step(left, left) + step(right, right)
    change = step(left, right) + step(right, left)
    costs = np.array([0.0, swap_cost])
    came_from = np.zeros((len(left), 2), dtype=np.int8)
    for frame in range(1, len(left)):
        same, other = costs + stay[frame - 1], costs[::-1] + change[frame - 1]
        came_from[frame] = np.where(same <= other, (0, 1), (1, 0))
        costs = np.minimum(same, other) + (0, swap_cost)
    states = np.empty(len(left), dtype=bool)
    state = int(np.argmin(costs))
    for frame in range(len(left) - 1, -1, -1):
        states[frame] = state
        state = came_from[frame, state]
    return states


def _held(values: np.ndarray) -> np.ndarray:
    """Paths (T, L, 3) with each gap filled by the point before it, or at the start the first seen."""
    seen = np.isfinite(values).all(axis=2)
    latest = np.maximum.accumulate(np.where(seen, np.arange(len(values))[:, None], -1), axis=0)
    latest = np.where(latest < 0, seen.argmax(axis=0), latest)
    return np.take_along_axis(values, latest[:, :, None], axis=0)
