# SPDX-License-Identifier: GPL-3.0-or-later
"""Animals on four legs, whose bones some rigs name like a person's."""

import numpy as np

from ..body.skeleton import JOINT_INDEX, Joints, limb_length, trunk_line
from ..motion.source import SourceMotion, UnusableMotion
from ..rotations import unit

ARM = ("shoulder", "elbow", "wrist")

SQUARE = np.sin(np.radians(40))
"""Largest cosine between the trunk and limbs that carry it."""

PARALLEL = np.cos(np.radians(45))
"""Least cosine between forelegs and hind legs that carry the trunk."""

MOSTLY = 0.75
"""Part of the frames: no clip of a person at hand is on all fours, off the knees, in half of them."""

LONG_ARMS = 0.8
"""Length of arms to legs: people's are .5 to .72, some cartoons' .8."""

SAMPLES = 100
"""Frames looked at."""


def refuse_four_legs(source: SourceMotion, matched: dict[int, int]) -> None:
    """Refuse an animal: two of its rest pose, its movement and the length of its forelegs show it.

    People crawl on their knees, and a person who walks on hands and feet has shorter arms and rests upright.
    """
    frames = np.linspace(0, source.n_frames - 1, min(SAMPLES, source.n_frames)).astype(int)
    moving = {joint: source.matrices[frames, bone, :3, 3] for joint, bone in matched.items()}
    resting = {joint: source.rest[bone, :3, 3] for joint, bone in matched.items()}
    signs = {
        "it rests on all fours": source.rest_is_known and bool(_on_all_fours(resting)),
        "it moves on all fours, off its knees": _on_all_fours(moving).mean() >= MOSTLY,
        "its arms are as long as its legs": limb_length(moving, ARM) > LONG_ARMS * limb_length(moving),
    }
    if sum(signs.values()) >= 2:
        why = " and ".join(sign for sign, is_there in signs.items() if is_there)
        raise UnusableMotion(f"its skeleton is that of an animal with four legs, not a person's: {why}")


def _on_all_fours(joints: Joints) -> np.ndarray:
    """Whether legs and arms stand off the trunk squarely and to one side, in each pose."""
    trunk = unit(trunk_line(joints))
    legs, arms = (_direction(joints, *ends) for ends in (("hip", "ankle"), ("shoulder", "wrist")))
    across = [abs(np.sum(trunk * limbs, axis=-1)) < SQUARE for limbs in (legs, arms)]
    found: np.ndarray = across[0] & across[1] & (np.sum(legs * arms, axis=-1) > PARALLEL)
    return found


def _direction(joints: Joints, start: str, end: str) -> np.ndarray:
    """Mean direction of both limbs."""
    ways = [
        joints[JOINT_INDEX[f"{side}_{end}"]] - joints[JOINT_INDEX[f"{side}_{start}"]]
        for side in ("left", "right")
    ]
    return unit(unit(ways[0]) + unit(ways[1]))
