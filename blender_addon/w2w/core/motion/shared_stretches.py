# SPDX-License-Identifier: GPL-3.0-or-later
"""Find clips that share a stretch of one motion, wherever each was cut."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .signature import RATE, WIDTH, Moments, Pairs, candidates, few_of_each, mirrored_poses

SHORTEST, SHARE, LONGEST = 0.5, 0.45, 2.0
"""A shared stretch lasts this part of the shorter clip, at least and at most so many seconds."""

NOISE = 0.009
"""Root mean square difference of copies by noise: that of 2 degrees in each joint at 30 frames a second."""

OF_MOVEMENT = 0.085
"""Difference of copies on other rigs, as a share of the movement; repetitions have .1 and more."""

AT_MOST = 0.2
"""Greatest difference as a share of the movement, noise included: quieter stretches say less than noise."""

STILL = 0.01
"""Root mean square of movement below which stretches are too quiet to be distinguished."""

QUIET, POSE, POSED = 0.045, 0.012, 1.5
"""A clip that moves by no more than the first is a copy of another in its pose, but for the second.

Noise then counts the third times. Real copies are at most .007 from their pose; of two who stand, none was
nearer than .027.
"""

AXES, PRINTED = 16, 8
"""Principal axes of poses on which clips are compared, and those of them on which moments are first."""

LEVELLED = 4
"""Axes of which a moment is marked when a clip crosses a level: copies cross it in the same pose."""

SPACING = 0.5
"""Distance of levels, in standard deviations of the axis."""

AT_REST, REST_EVERY = np.iinfo(np.int32).min, 10
"""Level of moments at which a clip hardly moves, and frames between them."""

AROUND = 2
"""Frames before and after a moment at which its movement is looked at."""

POSES, MOVES, BENT = 0.2, 0.07, 0.25
"""Units of differences of poses and of movements; of large movements relative to `BENT` of the unit."""

NEAR = np.arange(-10, 11, 5, np.float32)
"""Frames about a moment at which clips are aligned on all axes."""

STEP = 2.5
WIDE = np.arange(-40, 41, STEP, np.float32)
"""Frames about it at which they are then compared."""

APART = 1.25
"""Tolerances by which copies may differ on the axes; in full it is 1."""

LATE, FASTER = 0.75, 0.055
"""Frames by which moments of copies may miss one another, and part by which one copy may be faster."""

FOR_AXES, FRAMES_FOR_AXES = 2000, 20
"""Clips from which the axes are found, and frames of each, at most."""

CLIPS_AT_ONCE, PAIRS_AT_ONCE, IN_FULL_AT_ONCE = 400, 1000, 300
"""Clips read at a time, and pairs of moments compared on the axes and in full."""


def shared_stretches(
    signatures: Sequence[np.ndarray],
    clips: np.ndarray,
    frames: np.ndarray,
    is_known: Callable[[int, int], bool],
) -> Iterator[tuple[int, int]]:
    """Pairs of clips that share a stretch, mirrored or not; the nearest first, those that are known left out.

    `clips` (C,) are the numbers of those that are looked at, `frames` (C,) how many each has.
    """
    if len(clips) < 2:
        return
    axes, spacing = _axes(signatures, clips)
    every = np.eye(WIDTH, dtype=np.float32)
    mirror = mirrored_poses(every)
    as_is: list[Moments] = []
    asked: list[Moments] = []
    mirrored: list[Moments] = []
    for start in range(0, len(clips), CLIPS_AT_ONCE):
        block = slice(start, start + CLIPS_AT_ONCE)
        poses = _poses(signatures, clips[block])
        part, reflected = (_Lines.of(poses, frames[block], of) for of in (axes, mirror @ axes))
        as_is.append(Moments.joined([_moments(part, start, spacing)]))
        for side, moments in ((asked, as_is[-1]), (mirrored, _moments(reflected, start, spacing))):
            resting = moments.level == AT_REST
            side.append(few_of_each(moments.some(~resting | part.quiet[moments.clip - start])))
    base = Moments.joined(as_is)

    def apart_along(pairs: Pairs, ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
        """Difference of pairs whose poses are projected on these axes, (WIDTH, A) each: (C,)."""
        lines, places = [], []
        for asked_for, along in ((pairs.first, ours), (pairs.second, theirs)):
            numbers, place = np.unique(asked_for, return_inverse=True)
            lines.append(_Lines.of(_poses(signatures, clips[numbers]), frames[numbers], along))
            places.append(place)
        return _apart(replace(pairs, first=places[0], second=places[1]), *lines)

    for side, turned in ((asked, every), (mirrored, mirror)):
        pairs = candidates(Moments.joined(side), base)
        apart = np.empty(len(pairs.first))
        for start in range(0, len(apart), PAIRS_AT_ONCE):
            some = slice(start, start + PAIRS_AT_ONCE)
            apart[some] = apart_along(pairs.some(some), turned @ axes, axes)
        near = np.argsort(apart, kind="stable")[: np.count_nonzero(apart <= APART)]
        for start in range(0, len(near), IN_FULL_AT_ONCE):
            close = pairs.some(near[start : start + IN_FULL_AT_ONCE])
            numbers = zip(clips[close.first].tolist(), clips[close.second].tolist(), strict=True)
            close = close.some(np.array([not is_known(*pair) for pair in numbers]))
            if len(close.first):
                same = close.some(apart_along(close, turned, every) <= 1)
                yield from zip(clips[same.first].tolist(), clips[same.second].tolist(), strict=True)


def _poses(signatures: Sequence[np.ndarray], clips: np.ndarray) -> np.ndarray:
    """Poses of some clips, one after another, (F, WIDTH)."""
    return np.concatenate([signatures[clip] for clip in clips]).astype(np.float32).reshape(-1, WIDTH)


def _axes(signatures: Sequence[np.ndarray], clips: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal axes of poses and of their mirror images, (WIDTH, AXES), and the distance of levels."""
    sample = []
    for clip in clips[:: -(-len(clips) // FOR_AXES)]:
        poses = signatures[clip].reshape(-1, WIDTH)
        sample.append(poses[:: -(-len(poses) // FRAMES_FOR_AXES)].astype(np.float32))
    whole = np.concatenate(sample)
    variances, axes = np.linalg.eigh(np.cov(np.concatenate([whole, mirrored_poses(whole)]), rowvar=False))
    spacing = SPACING * np.sqrt(np.maximum(variances[::-1][:LEVELLED], 1e-6))
    return axes[:, ::-1][:, :AXES].astype(np.float32), spacing


@dataclass(frozen=True, eq=False)
class _Lines:
    """Poses of clips on axes, one after another, (F, A); frames of each and whether it hardly moves, (C,)."""

    poses: np.ndarray
    frames: np.ndarray
    quiet: np.ndarray

    @cached_property
    def start(self) -> np.ndarray:
        """The first frame of each clip."""
        return np.cumsum(self.frames) - self.frames

    @classmethod
    def of(cls, poses: np.ndarray, frames: np.ndarray, axes: np.ndarray) -> _Lines:
        """Lines of clips that have so many of some poses (F, WIDTH) each."""
        lines = poses @ axes
        start = np.cumsum(frames) - frames
        mean, squares = (np.add.reduceat(part, start, axis=0) / frames[:, None] for part in (lines, lines**2))
        return cls(lines, frames, (squares - mean**2).sum(axis=1) <= WIDTH * QUIET**2)

    def inside(self, clip: np.ndarray, moments: np.ndarray) -> np.ndarray:
        """Whether moments (C, K) are inside the clips (C,), or nearly."""
        return (moments > -LATE) & (moments < self.frames[clip][:, None] - 1 + LATE)

    def at(self, clip: np.ndarray, moments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Poses of clips (C,) at moments (C, K) and their changes per frame: (C, K, AXES) each."""
        before = np.clip(moments.astype(np.int64), 0, np.maximum(self.frames[clip] - 2, 0)[:, None])
        row = self.start[clip][:, None] + before
        poses = self.poses[row].astype(np.float32)
        change = self.poses[row + (self.frames[clip] > 1)[:, None]] - poses
        return poses + np.clip(moments - before, 0, 1)[..., None].astype(np.float32) * change, change


def _moments(clips: _Lines, number: int, spacing: np.ndarray) -> Moments:
    """Moments of clips, of which the first has this number."""
    lines = clips.poses[:, :PRINTED]
    clip = np.repeat(np.arange(len(clips.frames)), clips.frames)
    inner = np.arange(AROUND, len(lines) - AROUND - 1)
    inner = inner[clip[inner - AROUND] == clip[inner + AROUND + 1]]
    rest = inner[(inner - clips.start[clip[inner]] - AROUND) % REST_EVERY == 0]
    rest = rest[np.linalg.norm(lines[rest + AROUND] - lines[rest - AROUND], axis=1) <= QUIET * np.sqrt(WIDTH)]
    prints = np.pad(lines[rest] / (POSE * np.sqrt(WIDTH)), ((0, 0), (0, PRINTED - 1)))
    found: list[tuple[np.ndarray, ...]] = [
        (np.full(len(rest), AT_REST), rest, np.zeros((len(rest), 1)), prints)
    ]
    for axis, step in enumerate(spacing):
        height = np.floor(lines[:, axis] / step).astype(np.int64)
        low, high = height[inner], height[inner + 1]
        crossed = inner[low != high]
        before, after = height[crossed], height[crossed + 1]
        up = after > before
        level = np.where(up, after, before)
        share = (level * step - lines[crossed, axis]) / (lines[crossed + 1, axis] - lines[crossed, axis])
        share = share[:, None].astype(np.float32)
        start, middle, end = (
            lines[crossed + by] * (1 - share) + lines[crossed + by + 1] * share for by in (-AROUND, 0, AROUND)
        )
        movement = (end - start) / MOVES
        size = BENT * np.linalg.norm(movement, axis=1, keepdims=True)
        movement *= np.arcsinh(size) / np.maximum(size, 1e-9)
        pose = np.delete(middle, axis, axis=1) / POSES  # the axis itself says nothing more
        code = (level * 2 + up) * LEVELLED + axis
        found.append((code, crossed, share, np.concatenate([pose, movement], axis=1)))
    level, at, share, prints = (np.concatenate(part) for part in zip(*found, strict=True))
    frame = at - clips.start[clip[at]] + share[:, 0]
    return Moments(
        level.astype(np.int32),
        (clip[at] + number).astype(np.int32),
        frame.astype(np.float32),
        prints.astype(np.float16),
    )


def _apart(pairs: Pairs, one: _Lines, two: _Lines) -> np.ndarray:
    """Least difference of pairs of clips about a moment of each, in tolerances of copies, shape (C,)."""
    apart, late, faster = _aligned(pairs, one, two)
    near = np.flatnonzero(apart <= APART)
    pairs = pairs.some(near)
    at = pairs.moment[:, None] + WIDE
    there = (pairs.other + late[near])[:, None] + (1 + faster[near])[:, None] * WIDE
    inside = one.inside(pairs.first, at) & two.inside(pairs.second, there)
    ours = one.at(pairs.first, at)[0]
    shorter = np.minimum(one.frames[pairs.first], two.frames[pairs.second])
    points = (np.clip(SHARE * (shorter - 1), SHORTEST * RATE, LONGEST * RATE) // STEP).astype(int)
    moved, _ = _windows(ours, points)
    left, mean = _windows(ours - two.at(pairs.second, there)[0], points)
    posed = _quiet(pairs, one, two)[:, None] & (mean < POSE**2)
    ratio = left / _tolerance(moved, posed)
    whole = _sums(inside, points) == points[:, None]
    ratio[~(whole & (posed | (moved >= STILL**2)))] = np.inf
    apart[near] = np.sqrt(np.maximum(ratio.min(axis=1, initial=np.inf), 0))
    return apart


def _aligned(pairs: Pairs, one: _Lines, two: _Lines) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Difference near the moments, in tolerances, and how late and how much faster the second is: (C,)."""
    at, there = pairs.moment[:, None] + NEAR, pairs.other[:, None] + NEAR
    inside = one.inside(pairs.first, at) & two.inside(pairs.second, there)
    weights = (inside / inside.sum(axis=1, keepdims=True)).astype(np.float32)[..., None]

    def centred(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        mean = (weights * values).sum(axis=1, keepdims=True)
        return mean[:, 0], np.sqrt(weights) * (values - mean)

    def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("ckd,ckd->c", a, b)

    ours, _ = one.at(pairs.first, at)
    theirs, change = two.at(pairs.second, there)
    mean, apart = centred(ours - theirs)
    (_, moving), (_, shifted), (_, sped) = centred(ours), centred(change), centred(NEAR[:, None] * change)
    # least squares of apart - late * shifted - faster * sped
    aa, bb, ab = product(shifted, shifted) + 1e-9, product(sped, sped) + 1e-9, product(shifted, sped)
    a, b = product(apart, shifted), product(apart, sped)
    faster = ((aa * b - ab * a) / np.maximum(aa * bb - ab**2, 1e-12)).clip(-FASTER, FASTER)
    late = ((a - faster * ab) / aa).clip(-LATE, LATE)
    left = apart - late[:, None, None] * shifted - faster[:, None, None] * sped
    moved, left = product(moving, moving) / WIDTH, product(left, left) / WIDTH
    posed = _quiet(pairs, one, two) & ((mean**2).sum(axis=1) < WIDTH * POSE**2)
    return np.sqrt(left / _tolerance(moved, posed)), late, faster


def _quiet(pairs: Pairs, one: _Lines, two: _Lines) -> np.ndarray:
    """Whether the shorter clip of each pair hardly moves, (C,)."""
    shorter = one.frames[pairs.first] < two.frames[pairs.second]
    return np.where(shorter, one.quiet[pairs.first], two.quiet[pairs.second])


def _tolerance(moved: np.ndarray, posed: np.ndarray) -> np.ndarray:
    """Variance by which copies may differ, given that of the movement and whether both hold one pose."""
    tolerance = NOISE**2 + OF_MOVEMENT**2 * moved
    at_most = AT_MOST**2 * np.maximum(moved, STILL**2)
    return np.where(posed, POSED**2 * tolerance, np.minimum(tolerance, at_most))


def _sums(values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Sums of values (C, K, ...) over so many points (C,), from each on; of fewer at the end."""
    sums = np.cumsum(values, axis=1, dtype=np.float32)
    sums = np.concatenate([np.zeros_like(sums[:, :1]), sums], axis=1)
    end = np.minimum(np.arange(values.shape[1]) + points[:, None], values.shape[1])
    return sums[np.arange(len(values))[:, None], end] - sums[:, :-1]


def _windows(poses: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Variance of poses (C, K, A) over so many points, and their squared mean, from each on: (C, K) each."""
    mean = _sums(poses, points) / points[:, None, None]
    of_mean = np.einsum("ckd,ckd->ck", mean, mean) / WIDTH
    of_squares = _sums(np.einsum("ckd,ckd->ck", poses, poses), points) / points[:, None] / WIDTH
    return of_squares - of_mean, of_mean
