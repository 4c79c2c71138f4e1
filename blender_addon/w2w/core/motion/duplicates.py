# SPDX-License-Identifier: GPL-3.0-or-later
"""A short description of a motion by which two downloads of one motion are known as the same."""

from __future__ import annotations

import numpy as np

from ..body.skeleton import JOINT_INDEX, MIRRORED_JOINTS
from .motion import Motion

PHASES = 16
"""Moments, evenly over the clip, at which the pose is looked at."""

JOINTS = tuple(
    JOINT_INDEX[name]
    for name in (
        "left_hip", "right_hip", "left_knee", "right_knee", "spine2",
        "left_shoulder", "right_shoulder", "left_elbow", "right_elbow",
    )
)  # fmt: skip


SIZE = PHASES * len(JOINTS) * 6 + 1
"""Numbers of a signature, K."""


SIGNS = np.array([-1.0, 1.0, 1.0])[:, None] * np.array([-1.0, 1.0])
"""Of A R A with A = diag(-1, 1, 1), on the first two columns of R."""


def motion_signature(motion: Motion) -> np.ndarray:
    """Poses at even phases of a clip and its length, whoever moves and wherever they face.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    ndarray, shape (K,), float32
        Two columns of the rotation of each of `JOINTS` at `PHASES` moments, then the
        logarithm of the duration.
    """
    frames = np.linspace(0, motion.n_frames - 1, PHASES).round().astype(int)
    turns = motion.rotations[np.ix_(frames, JOINTS)][..., :2]
    return np.append(turns.ravel(), np.log(max(motion.duration, 1e-3))).astype(np.float32)


def mirrored_signatures(signatures: np.ndarray) -> np.ndarray:
    """Signatures of the same motions with left and right exchanged.

    Parameters
    ----------
    signatures : ndarray, shape (C, K)
        From `motion_signature`.

    Returns
    -------
    ndarray, shape (C, K)
    """
    signatures = np.asarray(signatures)
    turns = signatures[:, :-1].reshape(len(signatures), PHASES, len(JOINTS), 3, 2)
    partner = [JOINTS.index(MIRRORED_JOINTS[joint]) for joint in JOINTS]
    mirrored = turns[:, :, partner] * SIGNS.astype(signatures.dtype)
    return np.concatenate([mirrored.reshape(len(signatures), -1), signatures[:, -1:]], axis=1)
