# SPDX-License-Identifier: GPL-3.0-or-later
"""A short description of a motion by which two downloads of one motion are known as the same."""

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
        "neck", "head", "left_wrist", "right_wrist", "left_ankle", "right_ankle",
    )
)  # fmt: skip
"""All that a clip may move; a nod moves the head alone."""

POSED = np.arange(len(JOINTS)) < 9
"""Joints whose poses are alike on other rigs; of head, hands and feet only the movement is."""

POSES = np.append(np.broadcast_to(POSED[:, None], (PHASES, len(JOINTS), 6)).ravel(), True)
"""Which of a signature's K numbers copies are sought by: poses of `POSED`, and the length."""

SIGNS = np.array([-1.0, 1.0, 1.0])[:, None] * np.array([-1.0, 1.0])
"""Of A R A with A = diag(-1, 1, 1), on the first two columns of R."""

MOVED_ALIKE = 0.4
"""Copies differ in their movement by at most this share of it: real ones, on other rigs and at other rates,
by up to 0.31."""

STILL = 0.002
"""Root mean square below which poses differ by the noise of reading them, about a tenth of a degree."""

QUIET = 0.03
"""Root mean square of movement below which only clips of one length are copies: a nod has 0.012, the
quietest step 0.06. So little movement looks alike at another pace."""

ONE_LENGTH = 0.03
"""Greatest difference of one length, in its logarithm; copies at other frame rates differ by up to 0.016."""


def motion_signature(motion: Motion) -> np.ndarray:
    """Poses at even phases of a clip and its length, whoever moves and wherever they face; (K,), float32.

    Two columns of the rotation of each of `JOINTS` at `PHASES` moments, then the logarithm of the duration.
    """
    moments = np.linspace(0, motion.n_frames - 1, PHASES)
    before = moments.astype(int)
    after, share = np.minimum(before + 1, motion.n_frames - 1), (moments - before)[:, None, None, None]
    first, second = (motion.rotations[np.ix_(frames, list(JOINTS))][..., :2] for frames in (before, after))
    turns = first + share * (second - first)
    return np.append(turns.ravel(), np.log(max(motion.duration, 1e-3))).astype(np.float32)


def move_alike(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Pairs of motions (L,) that move alike, and last alike where they move little.

    Poses alone do not tell: whoever stands and nods stands like whoever shakes the head. Signatures are (L,
    K).
    """
    one, other = _movement(first), _movement(second)
    moved = np.sqrt(np.maximum((one**2).mean(axis=1), (other**2).mean(axis=1)))
    apart = np.sqrt(((one - other) ** 2).mean(axis=1))
    last_alike = np.abs(first[:, -1] - second[:, -1]) <= ONE_LENGTH
    return (apart <= np.maximum(MOVED_ALIKE * moved, STILL)) & (last_alike | (moved >= QUIET))


def _movement(signatures: np.ndarray) -> np.ndarray:
    """How poses differ from their mean over a clip, shape (L, K - 1)."""
    poses = signatures[:, :-1]
    turns = poses.reshape(len(poses), PHASES, 6 * len(JOINTS))
    return (turns - turns.mean(axis=1, keepdims=True)).reshape(poses.shape)


def mirrored_signatures(signatures: np.ndarray) -> np.ndarray:
    """Signatures (C, K) of the same motions with left and right exchanged."""
    signatures = np.asarray(signatures)
    turns = signatures[:, :-1].reshape(len(signatures), PHASES, len(JOINTS), 3, 2)
    partner = [JOINTS.index(MIRRORED_JOINTS[joint]) for joint in JOINTS]
    mirrored = turns[:, :, partner] * SIGNS.astype(signatures.dtype)
    return np.concatenate([mirrored.reshape(len(signatures), -1), signatures[:, -1:]], axis=1)
