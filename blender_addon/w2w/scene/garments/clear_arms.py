# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms held clear of the trunk while cloth is simulated: nothing can lie between parts that overlap.

A recorded pose on a body of another build sinks hanging arms some centimetres into trunk and hips.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ...core.body.body import Body
from ...core.body.skeleton import JOINT_INDEX
from ...core.motion.motion import Motion
from .overlap import ARM, closed, inside, limb, pushed_out, trunk

ANGLES = np.arange(0.0, 16.0, 3.0)
"""Angles by which an arm may be turned outward, degrees."""

AS_CLEAR = 0.05
"""Share of the overlap that a smaller angle may leave beyond the least that any leaves."""

FRAMES = 10
"""Frames of a clip looked at."""

SIDES = {"left": -1.0, "right": 1.0}


def with_clear_arms(body: Body, motion: Motion) -> Motion:
    """A motion with each arm turned outward at the shoulder, throughout, as far as it takes to be clear."""
    return replace(motion, rotations=_turned(motion, {side: outward(body, motion, side) for side in SIDES}))


def outward(body: Body, motion: Motion, side: str) -> float:
    """Degrees by which an arm has to be turned outward: the least of `ANGLES` that leaves next to no overlap.

    Parameters
    ----------
    body : Body
    motion : Motion
    side : str
        "left" or "right".
    """
    frames = np.unique(np.linspace(0, motion.n_frames - 1, FRAMES).round().astype(int))
    pelvis = motion.pelvis[frames] - motion.pelvis[frames[0]]  # single precision is finest at the origin
    few = replace(motion, rotations=motion.rotations[frames], pelvis=pelvis)
    trunks = closed(body, trunk(body), few)
    arm = limb(body, side, ARM)
    sunk = []
    for angle in ANGLES:
        turned = replace(few, rotations=_turned(few, {side: angle}))
        points = pushed_out(body, arm, turned)
        sunk.append(sum(inside(tree, own) for tree, own in zip(trunks, points, strict=True)))
        if not sunk[-1]:
            break
    bearable = min(sunk) + AS_CLEAR * sunk[0]
    return float(ANGLES[np.flatnonzero(np.array(sunk) <= bearable)[0]])


def _turned(motion: Motion, degrees: dict[str, float]) -> np.ndarray:
    rotations = motion.rotations.copy()
    for side, angle in degrees.items():
        turn = Rotation.from_euler("y", SIDES[side] * angle, degrees=True).as_matrix()
        joint = JOINT_INDEX[f"{side}_shoulder"]
        rotations[:, joint] = turn @ rotations[:, joint]
    return rotations
