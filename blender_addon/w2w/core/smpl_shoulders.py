# SPDX-License-Identifier: GPL-3.0-or-later
"""SMPL's way with shoulders, for a rig that comes from another body.

MakeHuman lets the cap of the shoulder follow the arm; SMPL blends trunk and arm across the shoulder
joint, square to the arm, and has the joint nearer to the arm's middle. A body of SMPL's faces that
takes over the bundled rig follows SMPL here, or raised arms drag the shoulder with them. The few
numbers below are one rule for four shoulders: how SMPL-Body's man and woman (Max Planck Institute
for Intelligent Systems, CC BY 4.0) change between their T- and A-poses.
"""

from __future__ import annotations

import numpy as np

from .skeleton import JOINT_INDEX

BLEND = (-0.1, 0.35)
"""Where the arm's share begins and is whole, in lengths of the upper arm outward from the shoulder joint."""

AROUND = (0.4, 0.7)
"""Distances from the arm's axis, in the same unit, between which the rule ceases to hold."""

WITHIN = 0.8
"""The rule holds for so far inward and outward of the joint, in the same unit."""

SLICE = (0.2, 0.4)
"""Part of the upper arm whose middle is taken for the arm's."""

TOWARDS_MIDDLE = 0.5
"""How far the joint is moved, of its way to the middle of the arm."""


def with_smpl_shoulders(
    vertices: np.ndarray, joints: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Give a rig SMPL's shoulders.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
        In W2W's T-pose.
    joints : ndarray, shape (24, 3)
    weights : ndarray, shape (V, 24)
        Rows sum to 1.

    Returns
    -------
    joints : ndarray, shape (24, 3)
        Only the shoulders differ.
    weights : ndarray, shape (V, 24)
        Only vertices near the shoulders differ; rows sum to 1.
    """
    joints, weights = joints.copy(), weights.copy()
    for side, outward in (("left", 1.0), ("right", -1.0)):
        arm = [JOINT_INDEX[f"{side}_{part}"] for part in ("shoulder", "elbow", "wrist", "hand")]
        start, bone = joints[arm[0]].copy(), joints[arm[1]] - joints[arm[0]]
        place = (vertices - start) / np.linalg.norm(bone)
        along = bone / np.linalg.norm(bone)
        share = weights[:, arm].sum(axis=1)
        joints[arm[0]] += TOWARDS_MIDDLE * np.linalg.norm(bone) * _middle(place, along, share)
        wanted, held = _blend(place * [outward, 1, 1])
        share = np.clip(share + held * (wanted - share), 0, 1)
        _share_out(weights, arm, JOINT_INDEX[f"{side}_collar"], share)
    return joints, weights


def _middle(place: np.ndarray, along: np.ndarray, share: np.ndarray) -> np.ndarray:
    """From the joint to the middle line of the upper arm, in the frontal plane; 0 where no arm is."""
    depth = place @ along
    of_arm = (depth > SLICE[0]) & (depth < SLICE[1]) & (share > 0.5)
    if not of_arm.any():
        return np.zeros(3)
    offset = (place[of_arm].min(axis=0) + place[of_arm].max(axis=0)) / 2
    aside = offset - along * (offset @ along)
    return aside * [1, 0, 1]  # front to back the joints agree already


def _blend(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """SMPL's share of the arm at each vertex, and how much that counts there, both shape (V,)."""
    depth, aside = place[:, 0], np.linalg.norm(place[:, 1:], axis=1)
    return _smoothstep(depth, *BLEND), (1 - _smoothstep(aside, *AROUND)) * (np.abs(depth) < WITHIN)


def _share_out(weights: np.ndarray, arm: list[int], collar: int, share: np.ndarray) -> None:
    """Scale each row's weights on the arm to a share and the others to the rest, in place.

    Where a vertex follows nothing of the kind yet, shoulder and collar take what is due.
    """
    trunk = np.setdiff1d(np.arange(weights.shape[1]), arm)
    for joints, taker, due in ((arm, arm[0], share), (trunk, collar, 1 - share)):
        held = weights[:, joints].sum(axis=1)
        bare = held < 1e-6
        weights[:, joints] *= np.where(bare, 0, due / np.where(bare, 1, held))[:, None]
        weights[bare, taker] = due[bare]


def _smoothstep(values: np.ndarray, start: float, end: float) -> np.ndarray:
    share = np.clip((values - start) / (end - start), 0, 1)
    return share * share * (3 - 2 * share)
