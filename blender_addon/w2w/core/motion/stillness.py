# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a motion moves, and whether that is more than a pose."""

from __future__ import annotations

import numpy as np

from .source import NOT_FINITE, SourceMotion, UnusableMotion

MIN_FRAMES = 4
"""Fewer frames than a cubic spline needs are a pose, not a motion."""

MIN_TURN = np.radians(0.5)
MIN_TRAVEL = 0.005
"""A motion moves where a bone turns by `MIN_TURN` or travels `MIN_TRAVEL` of the skeleton's size."""


def motion_amount(motion: SourceMotion) -> float:
    """How much a motion moves: its widest turn or travel in units of the least that counts."""
    heads = motion.matrices[:, :, :3, 3]
    size = np.ptp(motion.rest[:, :3, 3], axis=0).max()
    travel = np.ptp(heads, axis=0).max() / max(size, 1e-12)
    axes = motion.matrices[:, :, :3, 1]
    axes = axes / np.maximum(np.linalg.norm(axes, axis=-1, keepdims=True), 1e-12)
    turn = np.linalg.norm(np.ptp(axes, axis=0), axis=-1).max()
    return float(max(travel / MIN_TRAVEL, turn / MIN_TURN))


def is_pose(motion: SourceMotion) -> bool:
    """Whether a motion is too short, or moves too little, to be one."""
    return motion.n_frames < MIN_FRAMES or motion_amount(motion) < 1


def refuse_pose(motion: SourceMotion) -> None:
    """Refuse a motion that does not move.

    Raises
    ------
    UnusableMotion
        If it is too short, nothing moves in it, or it holds values that no body has.
    """
    if not np.isfinite(motion.matrices).all():
        raise UnusableMotion(NOT_FINITE)
    if motion.n_frames < MIN_FRAMES:
        count = f"{motion.n_frames} frame{'s' * (motion.n_frames != 1)}"
        raise UnusableMotion(f"it holds a pose, not a motion: {count} in '{motion.take}'")
    if motion_amount(motion) < 1:
        raise UnusableMotion(
            "it holds a pose, not a motion: "
            f"nothing moves over the {motion.n_frames} frames of '{motion.take}'"
        )
