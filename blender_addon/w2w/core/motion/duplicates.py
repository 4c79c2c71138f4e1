# SPDX-License-Identifier: GPL-3.0-or-later
"""Tell whether two clips share a stretch of one motion, wherever each was cut."""

import numpy as np

from ..body.skeleton import JOINT_INDEX, MIRRORED_JOINTS
from .motion import Motion

JOINTS = tuple(
    JOINT_INDEX[name]
    for name in (
        "left_hip", "right_hip", "left_knee", "right_knee", "spine2",
        "left_shoulder", "right_shoulder", "left_elbow", "right_elbow",
        "neck", "head", "left_wrist", "right_wrist", "left_ankle", "right_ankle",
    )
)  # fmt: skip

WIDTH = 6 * len(JOINTS)
"""Numbers of a pose: two columns of each joint's rotation."""

RATE = 20.0
"""Poses of a signature per second."""

SMOOTHED = 0.07
"""Standard deviation of the Gaussian that smooths poses, seconds: it takes out noise."""

SIGNS = np.array([-1.0, 1.0, 1.0])[:, None] * np.array([-1.0, 1.0])
"""Signs of A R A with A = diag(-1, 1, 1), on the first two columns of R."""

SHORTEST, SHARE, LONGEST = 0.5, 0.45, 2.0
"""A shared stretch lasts this part of the shorter clip, at least and at most so many seconds."""

NOISE = 0.009
"""Root mean square difference of copies by noise: that of 2 degrees in each joint at 30 frames a second."""

OF_MOVEMENT = 0.085
"""Difference of copies on other rigs, as a share of the movement; repetitions have .1 and more."""

AT_MOST = 0.2
"""Greatest difference as a share of the movement, noise included: quieter stretches say less than noise."""

STILL = 0.01
"""Root mean square of movement below which stretches are too quiet to be told apart."""

SPEEDS = (1.0, 0.975, 1.025, 0.95, 1.05)
"""Speeds of one clip relative to the other that are tried; 1 comes first."""

SHIFT = 0.5
"""Frames by which stretches are shifted to find the best fit."""

REACHED = 5
"""Frames that other speeds reach beyond a stretch."""

FAR = 1.5
"""Tolerances, for each second of the stretch, by which copies at other speeds may differ at equal speeds."""


def motion_signature(motion: Motion) -> np.ndarray:
    """Smoothed poses at `RATE`, whoever moves and wherever they face: shape (n * WIDTH,), float16.

    A line is fitted to the frames around each moment, so the ends of a cut clip are as they are inside the
    whole.
    """
    last = motion.n_frames - 1
    poses = motion.rotations[:, list(JOINTS)][..., :2].reshape(motion.n_frames, WIDTH)
    times = np.arange(int(motion.duration * RATE + 1e-6) + 1) / RATE * motion.rate
    reach = int(np.ceil(2.5 * SMOOTHED * motion.rate))
    frames = np.round(times).astype(int)[:, None] + np.arange(-reach, reach + 1)
    away = frames - times[:, None]
    weights = np.exp(-0.5 * (away / (SMOOTHED * motion.rate)) ** 2) * ((frames >= 0) & (frames <= last))
    total, first, second = ((weights * away**power).sum(axis=1) for power in range(3))
    spread = total * second - first**2
    line = weights * (second[:, None] - first[:, None] * away)
    weights = np.where(
        spread[:, None] > 1e-9, line / np.maximum(spread, 1e-9)[:, None], weights / total[:, None]
    )
    signature = np.zeros((len(times), WIDTH))
    for near, weight in zip(frames.clip(0, last).T, weights.T, strict=True):
        signature += weight[:, None] * poses[near]
    return signature.astype(np.float16).ravel()


def mirrored_poses(poses: np.ndarray) -> np.ndarray:
    """Poses (n, WIDTH) with left and right exchanged."""
    turns = poses.reshape(len(poses), len(JOINTS), 3, 2)
    partner = [JOINTS.index(MIRRORED_JOINTS[joint]) for joint in JOINTS]
    return (turns[:, partner] * SIGNS.astype(poses.dtype)).reshape(len(poses), WIDTH)


def share_stretch(
    first: np.ndarray, second: np.ndarray, moment: float, other: float, mirrored: bool = False
) -> bool:
    """Whether two clips show one motion for long enough about a moment of each, the first mirrored or not.

    Poses are (n, WIDTH) and (m, WIDTH), moments in frames of each.
    """
    shorter = (min(len(first), len(second)) - 1) / RATE
    length = round(RATE * min(max(SHORTEST, SHARE * shorter), LONGEST)) + 1
    start, there = max(0, int(moment) - length), max(0, int(other) - length - REACHED)
    first = first[start : int(moment) + length + 1].astype(np.float32)
    second = second[there : int(other) + length + REACHED].astype(np.float32)
    first = mirrored_poses(first) if mirrored else first
    for speed in SPEEDS:
        apart = _least_apart(first, second, moment - start, other - there, speed, length)
        if apart <= 1:
            return True
        if apart > 1 + FAR * length / RATE:
            return False
    return False


def _least_apart(
    first: np.ndarray, second: np.ndarray, moment: float, other: float, speed: float, length: int
) -> float:
    """Least difference of all stretches of so many frames, in tolerances, at one speed."""
    there = other + (np.arange(len(first)) - moment) * speed
    inside = (there >= -SHIFT) & (there <= len(second) - 1 + SHIFT)
    if inside.sum() < length:
        return np.inf
    here, there = first[inside], there[inside]
    moved = _variance(here, length)
    before, apart, after = (
        _variance(here - _at(second, there + shift), length) for shift in (-SHIFT, 0.0, SHIFT)
    )
    bend = before + after - 2 * apart
    lowest = (bend > 0) & (np.abs(after - before) <= bend)
    apart = apart - np.divide((after - before) ** 2, 8 * bend, where=lowest, out=np.zeros_like(bend))
    loud = moved >= STILL**2
    apart, moved = apart[loud], moved[loud]
    apart /= np.minimum(NOISE**2 + OF_MOVEMENT**2 * moved, AT_MOST**2 * moved)
    return float(np.sqrt(max(apart.min(initial=np.inf), 0.0)))


def _at(poses: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Poses between frames, the first and the last beyond the ends."""
    before = moments.astype(int).clip(0, len(poses) - 2)
    share = (moments - before).clip(0, 1).astype(poses.dtype)[:, None]
    return poses[before] + share * (poses[before + 1] - poses[before])


def _variance(poses: np.ndarray, length: int) -> np.ndarray:
    """Variance over so many frames of poses (n, WIDTH), the mean over their numbers: (n - length + 1,)."""
    poses = poses - poses[:1]  # so that sums stay small
    sums = np.cumsum(poses, axis=0)
    sums[length:] -= sums[:-length].copy()
    squares = np.cumsum(np.append(0.0, np.einsum("nw,nw->n", poses, poses)))
    mean = sums[length - 1 :] / length
    of_mean = np.einsum("nw,nw->n", mean, mean)
    return ((squares[length:] - squares[:-length]) / length - of_mean) / WIDTH
