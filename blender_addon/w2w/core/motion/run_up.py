# SPDX-License-Identifier: GPL-3.0-or-later
"""The run-up before a clip in which cloth settles: from the T-pose it was cut in, at rest, up to speed."""

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..rotations import rotation_vectors
from .motion import Motion, at_rate

LEAST_RATE = 50.0
"""Frames per second that cloth is simulated at, at least."""

POSE_S, SETTLE_S, RUN_UP_S = 0.8, 0.4, 0.4
"""Seconds from the T-pose to the first pose, for the cloth to come to rest there, and up to speed."""

MOST_TURN, MOST_WAY = 1.0, 0.5
"""How far the run-up may reach back, radians and metres: a first frame may be a glitch."""


def with_run_up(motion: Motion, reach: float = 1.0) -> tuple[Motion, int]:
    """A motion at `cloth_rate`, after a run-up during which cloth settles, and the frames of that run-up.

    The body stands in the T-pose, turned as the clip begins, takes a pose just before the clip's first,
    waits there and moves off at constant acceleration, so that each joint enters the clip's first frame
    with the clip's own velocity. `reach`, above 0 and at most 1, is how far back the pose is in which it
    waits: the shorter, the later and the harder it moves off. The whole is moved to the origin, where
    single precision is finest; sensors do not feel the place. It ends no earlier than the clip.
    """
    clip = _at_cloth_rate(motion)
    rate = clip.rate
    turn, way = _first_step(clip)
    run_up_s = reach * RUN_UP_S
    speeding = _times(run_up_s, rate)
    back = run_up_s / 2 - speeding**2 / (2 * run_up_s)  # seconds at the first speed still to go
    turned, moved = _before_first(clip, turn, way, np.concatenate([[run_up_s / 2], back]))
    share = _times(POSE_S, rate) / POSE_S
    from_t_pose = _from_t_pose(turned[0], share**2 * (3 - 2 * share))
    still = len(_times(SETTLE_S, rate)) + len(_times(RUN_UP_S, rate)) - len(speeding)
    rotations = [from_t_pose, np.repeat(turned[:1], still, axis=0), turned[1:], clip.rotations]
    paths = [np.repeat(moved[:1], len(share) + still, axis=0), moved[1:], clip.pelvis]
    pelvis = np.concatenate(paths) - clip.pelvis.mean(axis=0) * (1, 1, 0)
    whole = replace(clip, rotations=np.concatenate(rotations), pelvis=pelvis)
    return whole, whole.n_frames - clip.n_frames


def reached_back(motion: Motion, reach: float) -> Motion:
    """Poses of the run-up: the one in which the body waits, one half-way from there, and the clip's first.

    The last one's pelvis is at the origin, near which single precision is finest.
    """
    clip = _at_cloth_rate(motion)
    seconds = reach * RUN_UP_S / 2 * np.array([1.0, 0.5, 0.0])
    rotations, pelvis = _before_first(clip, *_first_step(clip), seconds)
    return replace(clip, rotations=rotations, pelvis=pelvis - pelvis[-1])


def cloth_rate(rate: float) -> float:
    """Frames per second to simulate a motion at: a whole part or multiple of its own, from 50 up to 100."""
    if rate < LEAST_RATE:
        return rate * math.ceil(LEAST_RATE / rate)
    return rate / (rate // LEAST_RATE)


def _at_cloth_rate(motion: Motion) -> Motion:
    """The motion at `cloth_rate`; its last pose is held if the rate leaves a rest."""
    clip = at_rate(motion, cloth_rate(motion.rate))
    if clip.duration >= motion.duration - 1e-9:
        return clip
    return replace(
        clip,
        rotations=np.concatenate([clip.rotations, motion.rotations[-1:]]),
        pelvis=np.concatenate([clip.pelvis, motion.pelvis[-1:]]),
    )


def _first_step(clip: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Turn of each joint and way of the pelvis in a second, at the first frame's speed."""
    if clip.n_frames < 2:
        return np.zeros((clip.rotations.shape[1], 3)), np.zeros(3)
    relative = clip.rotations[0].swapaxes(-1, -2) @ clip.rotations[1]
    turn = rotation_vectors(relative) * clip.rate
    way = (clip.pelvis[1] - clip.pelvis[0]) * clip.rate
    return _at_most(turn, 2 * MOST_TURN / RUN_UP_S), _at_most(way, 2 * MOST_WAY / RUN_UP_S)


def _at_most(vectors: np.ndarray, length: float) -> np.ndarray:
    longest = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors * np.minimum(1, length / np.maximum(longest, 1e-12))


def _before_first(
    clip: Motion, turn: np.ndarray, way: np.ndarray, seconds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Poses some seconds before the first frame, at that frame's speed: rotations and the pelvis's path."""
    vectors = (-seconds[:, None, None] * turn).reshape(-1, 3)
    turns = Rotation.from_rotvec(vectors).as_matrix().reshape(len(seconds), -1, 3, 3)
    return clip.rotations[0] @ turns, clip.pelvis[0] - seconds[:, None] * way


def _from_t_pose(pose: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Poses on the way from the T-pose to a pose, the pelvis turned as there from the beginning."""
    vectors = rotation_vectors(pose)
    shares = np.repeat(share[:, None], len(pose), axis=1)
    shares[:, 0] = 1.0
    turned = (shares[..., None] * vectors).reshape(-1, 3)
    return Rotation.from_rotvec(turned).as_matrix().reshape(len(share), len(pose), 3, 3)


def _times(seconds: float, rate: float) -> np.ndarray:
    """Times of the frames that a stretch of the run-up takes, from 0 on, without its end."""
    count = max(1, round(seconds * rate))
    return np.arange(count) * (seconds / count)
