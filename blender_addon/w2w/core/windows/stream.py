# SPDX-License-Identifier: GPL-3.0-or-later
"""A stream of clips: performed one after another with standing between them, and cut where windows fall."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_INDEX, N_JOINTS, Body
from ..imu.recording import ImuRecording
from ..imu.sensor import SensorModel
from ..imu.synthesis import Synthesis
from ..imu.virtual import record_motion
from ..motion.motion import Motion
from ..patches.patches import PatchSet
from ..rotations import rotation_vectors, smallest_rotation
from .windows import WindowSpec, cut_windows

STANDING_S = (1.0, 2.5)
"""Shortest and longest standing between two clips, with the way there and back."""

BLEND_S = 0.4
"""Seconds in which a body comes to stand, and in which it starts from there."""

ARMS_DOWN_DEG = 75.0
"""Turn of the arms of a T-pose that lets them hang."""

STILL_FRAMES = 50
"""Frames of standing that are recorded: enough for the synthesis's filters."""

HELD = 0.5
"""Share of a clip, or of the window where that is shorter, that a window must hold to count as the clip's."""

NO_CLIP = -1
"""Owner of a window that holds no clip: it shows standing."""


class StreamWindows(NamedTuple):
    """Windows of a stream (W, N, samples, 6), as `cut_windows` gives them, and each one's clip (W,)."""

    signals: np.ndarray
    clip: np.ndarray  # int, by place among the clips; NO_CLIP for standing


def standing_reading(body: Body, patches: PatchSet, settings: Synthesis) -> np.ndarray:
    """Ideal readings, shape (N, 6), at each patch of a body that stands still with its arms down."""
    rotations = np.tile(np.eye(3), (STILL_FRAMES, N_JOINTS, 1, 1))
    for side, sign in (("left", 1), ("right", -1)):
        turn = Rotation.from_euler("y", sign * ARMS_DOWN_DEG, degrees=True)
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = turn.as_matrix()
    still = Motion(rotations, np.zeros((STILL_FRAMES, 3)), rate=settings.rate_hz)
    return record_motion(body, patches, still, settings).values[STILL_FRAMES // 2]


def stream_windows(
    clips: Sequence[ImuRecording],
    standing: np.ndarray,
    sensor: SensorModel,
    length_s: float,
    draw: Sequence[int],
) -> StreamWindows:
    """Windows, one every half window, of clips in a drawn order with standing of a drawn length between them.

    A window is of the clip that it holds most of, if it holds half of that clip or is half filled by it.
    `standing` (N, 6) is from `standing_reading`, for the sensors of the clips; `draw` seeds order, lengths
    and phase.
    """
    rng, rate, spec = np.random.default_rng(draw), clips[0].rate, WindowSpec.of_length(length_s)
    samples = spec.samples(rate)
    order = rng.permutation(len(clips))
    pauses = np.rint(rng.uniform(*STANDING_S, len(clips) + 1) * rate).astype(int)
    pauses[0] += rng.integers(spec.stride(rate))
    played = [np.concatenate([clips[k].acc, clips[k].gyr], axis=2) for k in order]
    lengths = np.array([len(one) for one in played])
    pauses[-1] += max(0, samples - pauses.sum() - lengths.sum())
    between = _pauses(played, standing, pauses, rate)
    named = ImuRecording(
        between[..., :3], between[..., 3:], rate, clip="standing " + " ".join(map(str, draw))
    )
    read = np.split(sensor.apply(named, draw[0]).values, np.cumsum(pauses)[:-1])
    whole = np.concatenate([part for pair in zip(read, played, strict=False) for part in pair] + read[-1:])
    stream = ImuRecording(whole[..., :3], whole[..., 3:], rate)
    signals, _, starts = cut_windows(stream, spec)
    first = np.cumsum(pauses[:-1] + np.concatenate([[0], lengths[:-1]]))
    inside = np.minimum(starts[:, None] + samples, first + lengths) - np.maximum(starts[:, None], first)
    inside = np.where(inside >= HELD * np.minimum(lengths, samples), inside, 0)
    owner = np.where(inside.any(axis=1), order[inside.argmax(axis=1)], NO_CLIP)
    return StreamWindows(signals, owner)


def _pauses(
    played: Sequence[np.ndarray], standing: np.ndarray, counts: np.ndarray, rate: float
) -> np.ndarray:
    """Ideal signals (T, N, 6) of all pauses of some samples each, one after another."""
    ends = (
        np.array([standing, *(one[-1] for one in played)]),
        np.array([*(one[0] for one in played), standing]),
    )
    before, after = (np.where(np.isfinite(one), one, standing) for one in ends)
    blended = round(BLEND_S * rate)
    pauses = np.tile(standing, (counts.sum(), 1, 1))
    last = np.cumsum(counts)
    steps = np.arange(blended)[:, None]
    pauses[last - counts + steps] = _way(before, standing, blended, rate)
    pauses[last - blended + steps] = _way(standing, after, blended, rate)
    return pauses


def _way(start: np.ndarray, end: np.ndarray, count: int, rate: float) -> np.ndarray:
    """Signals (count, ..., 6) between two readings (..., 6): gravity turns the shortest way, smoothly.

    The gyroscope reads that turn, and its own readings fade.
    """
    start, end = np.broadcast_arrays(start, end)
    part = (np.arange(count) + 1).reshape(-1, *[1] * start.ndim) / (count + 1)
    share = part**3 * (10 - 15 * part + 6 * part**2)  # least jerk
    speed = 30 * (part * (1 - part)) ** 2 * rate / (count + 1)
    lengths = [np.linalg.norm(one[..., :3], axis=-1, keepdims=True) for one in (start, end)]
    before, after = (
        one[..., :3] / np.maximum(of, 1e-6) for one, of in zip((start, end), lengths, strict=True)
    )
    turn = rotation_vectors(smallest_rotation(before, after))
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    across = np.cross(turn / np.maximum(angle, 1e-9), before)  # square to the axis as `before` is
    force = before * np.cos(angle * share) + across * np.sin(angle * share)
    force *= lengths[0] + (lengths[1] - lengths[0]) * share
    turning = start[..., 3:] + (end[..., 3:] - start[..., 3:]) * share - turn * speed
    return np.concatenate([force, np.broadcast_to(turning, force.shape)], axis=-1)
