# SPDX-License-Identifier: GPL-3.0-or-later
"""Find clips whose joints turn at the same speeds: copies that `shared_stretches` cannot know by their poses.

A joint turned by a constant, as on a rig with another rest pose, turns at the same speeds. Larger movements
are faster by one factor, and a reversed clip has the speeds of the clip, backwards. The upper body alone is
compared, so the legs may be another clip's.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from ..body.body import MIRRORED_JOINTS
from .shared_stretches import SHARE
from .signature import JOINTS, RATE, WIDTH, Moments, candidates, few_of_each

UPPER = slice(4, 13)
"""Places among `JOINTS` of the upper body."""

MIRRORED = [JOINTS[UPPER].index(MIRRORED_JOINTS[joint]) for joint in JOINTS[UPPER]]
"""Places of the joints of the upper body with left and right exchanged."""

THE_SAME = 0.99
"""Least correlation of the speeds of copies; of repetitions by one performer, halves had up to .989."""

SHORTEST = 20
"""Frames over which speeds are compared at least; more are a part of the shorter clip."""

MOVES = 0.05
"""Root mean square of speeds, radians a second, below which clips are too quiet to be distinguished."""

AROUND = np.arange(-6, 7, 3)
"""Frames about a moment at which its print is taken."""

UNIT = 0.25
"""Unit of differences of prints, as a share of the speed at the moment."""

WIDE = np.arange(-80, 81)
"""Frames about a moment over which speeds are compared."""

LATE = np.arange(-0.5, 0.51, 0.25, np.float32)
"""Frames by which moments of copies may miss one another."""

CLIPS_AT_ONCE, HELD = 50, 400
"""Clips read at a time, and those whose speeds are held: a clip is in many pairs."""


def same_speeds(
    signatures: Sequence[np.ndarray],
    clips: np.ndarray,
    frames: np.ndarray,
    is_known: Callable[[int, int], bool],
) -> Iterator[tuple[int, int]]:
    """Pairs of clips whose speeds are the same, mirrored or reversed or not; those that are known left out.

    `clips` (C,) are the numbers of those that are looked at, `frames` (C,) how many each has.
    """
    clips, frames = clips[frames > SHORTEST], frames[frames > SHORTEST]
    if len(clips) < 2:
        return
    base, asked = [], []
    for start in range(0, len(clips), CLIPS_AT_ONCE):
        block = slice(start, start + CLIPS_AT_ONCE)
        poses = np.concatenate([signatures[clip] for clip in clips[block]])
        base.append(_moments(_speeds(poses), frames[block], start))
        asked.append(few_of_each(base[-1]))
    speeds = lru_cache(HELD)(lambda clip: _speeds(signatures[clip]))
    whole, few = Moments.joined(base), Moments.joined(asked)
    for mirror, reverse in product((False, True), repeat=2):
        pairs = candidates(Moments.joined([_seen(few, frames - 1, mirror, reverse)]), whole)
        for n, (first, second) in enumerate(zip(clips[pairs.first], clips[pairs.second], strict=True)):
            if not is_known(int(first), int(second)):
                ours = speeds(first)[:: -1 if reverse else 1]
                ours = ours[:, MIRRORED] if mirror else ours
                moments = float(pairs.moment[n]), float(pairs.other[n])
                if _correlation(ours, speeds(second), *moments) >= THE_SAME:
                    yield int(first), int(second)


def _speeds(poses: np.ndarray) -> np.ndarray:
    """Speeds (F - 1, J) at which joints of the upper body turn from pose to pose, radians a second."""
    first, second = np.moveaxis(poses.reshape(-1, WIDTH // 6, 3, 2)[:, UPPER].astype(np.float32), -1, 0)
    axes = np.diff([first, second, np.cross(first, second)], axis=1)
    return RATE * np.sqrt(np.einsum("afjd,afjd->fj", axes, axes) / 2)


def _moments(speeds: np.ndarray, frames: np.ndarray, number: int) -> Moments:
    """Moments at which clips of so many frames move faster than before and after; `number` is the first's.

    Their speeds follow each other, with one between clips.
    """
    start, clip = np.cumsum(frames) - frames, np.repeat(np.arange(len(frames)), frames)[:-1]
    total = np.linalg.norm(speeds, axis=1)
    at = np.arange(-AROUND[0], len(total) - AROUND[-1])
    at = at[clip[at + AROUND[0]] == clip[(at + AROUND[-1] + 1).clip(max=len(clip) - 1)]]
    peak = (total[at] > total[at - 1]) & (total[at] >= total[at + 1])
    at = at[peak & (total[at] > MOVES * np.sqrt(speeds.shape[1]))]
    before, here, after = total[at - 1], total[at], total[at + 1]
    clip, own = clip[at], at - start[clip[at]]
    # the top of a parabola through the three
    moments = own + ((before - after) / np.minimum(before - 2 * here + after, -1e-9) / 2).clip(-0.5, 0.5)
    around = _at(speeds, moments[:, None] + AROUND, start[clip, None], frames[clip, None] - 1)
    fastest = around[:, len(AROUND) // 2]
    prints = around / np.linalg.norm(fastest, axis=1)[:, None, None] / UNIT
    prints = prints.reshape(len(prints), len(AROUND) * len(MIRRORED)).astype(np.float16)
    level, clip = fastest.argmax(axis=1).astype(np.int32), (clip + number).astype(np.int32)
    return Moments(level, clip, moments.astype(np.float32), prints)


def _seen(moments: Moments, frames: np.ndarray, mirror: bool, reverse: bool) -> Moments:
    """The moments of clips that have so many frames (C,), seen in a mirror and backwards, or not."""
    if mirror:
        prints = moments.prints.reshape(-1, len(MIRRORED))[:, MIRRORED].reshape(moments.prints.shape)
        moments = replace(moments, level=np.array(MIRRORED, np.int32)[moments.level], prints=prints)
    if reverse:
        prints = moments.prints.reshape(-1, len(AROUND), len(MIRRORED))[:, ::-1].reshape(moments.prints.shape)
        moments = replace(moments, frame=frames[moments.clip] - 1 - moments.frame, prints=prints)
    return moments


def _at(speeds: np.ndarray, moments: np.ndarray, start: Any = 0, count: Any = None) -> np.ndarray:
    """Speeds (..., J) at moments (...), between frames, too: of clips that start there and have so many."""
    before = np.clip(moments.astype(int), 0, (len(speeds) if count is None else count) - 2)
    share, row = (moments - before).clip(0, 1)[..., None].astype(np.float32), start + before
    return speeds[row] * (1 - share) + speeds[row + 1] * share


def _correlation(one: np.ndarray, two: np.ndarray, moment: float, other: float) -> float:
    """The highest correlation of the speeds of two clips about a moment of each; 0 if they are too quiet."""
    inside = (1 - min(moment, other) < WIDE) & (min(len(one) - moment, len(two) - other) - 2 > WIDE)
    if inside.sum() < max(SHORTEST - 4, SHARE * min(len(one), len(two), len(WIDE))):
        return 0.0
    ours = _at(one, moment + WIDE[inside])
    theirs = _at(two, other + LATE[:, None] + WIDE[inside])
    ours, theirs = ours - ours.mean(axis=0), theirs - theirs.mean(axis=1, keepdims=True)
    of_ours, of_theirs = np.square(ours).mean(), np.square(theirs).mean(axis=(1, 2))
    if min(of_ours, of_theirs.min()) < MOVES**2:
        return 0.0
    return float(((ours * theirs).mean(axis=(1, 2)) / np.sqrt(of_ours * of_theirs)).max())
