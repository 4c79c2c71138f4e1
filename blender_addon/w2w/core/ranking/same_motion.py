# SPDX-License-Identifier: GPL-3.0-or-later
"""Find clips that show one and the same motion, so that none is tested on its own copy."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..motion.duplicates import WIDTH, mirrored_poses, share_stretch

AXES = 8
"""Principal axes of poses on which moments are compared."""

LEVELLED = 4
"""Axes of which a moment is marked when a clip crosses a level: copies cross it in the same pose."""

SPACING = 0.5
"""Distance of levels, in standard deviations of the axis."""

AROUND = 3
"""Frames before and after a moment at which its movement is looked at."""

POSES, MOVES, BENT = 0.2, 0.1, 0.25
"""Units of differences of poses and of movements; of large movements relative to `BENT` of the unit."""

REACH = 1.0
"""Greatest distance, in these units, of moments that are looked at closely."""

ASKED = 8
"""Moments of a clip for which near ones are sought, about; in the others it is found."""

NEAREST, TRIES = 4, 2
"""Nearest clips with which a clip is compared, and nearest moments of both at which they are, at most."""

FOR_AXES = 2000
"""Signatures from which the axes are found, at most."""

CLIPS_AT_ONCE = 1000
"""Signatures read at a time."""

PRODUCTS = 4_000_000
"""Products of moments held at a time, 16 MB."""


def same_motion_groups(
    clips: Sequence[str],
    keys: Sequence[str] | None = None,
    signatures: Sequence[np.ndarray] | None = None,
) -> np.ndarray:
    """Number the distinct motions among C clips, in order of appearance, shape (C,), int.

    Two clips are the same if their names or keys are equal or they share a stretch of one motion, mirrored or
    not. Sameness is passed on: if a equals b and b equals c, all three are one. An empty key or signature
    says nothing.

    Parameters
    ----------
    signatures : sequence of ndarrays, length C, optional
        `motion_signature` of each clip.

    Raises
    ------
    ValueError
        If a signature is none of today's, as in folders of earlier versions.
    """
    joined = _Joined(len(clips))
    joined.join_equal(list(clips))
    if keys is not None:
        joined.join_equal([key or None for key in keys])
    if signatures is not None:
        distinct = joined.join_equal([_digest(row) for row in signatures])
        _join_shared(signatures, distinct, joined)
    roots = [joined.root(clip) for clip in range(len(clips))]
    _, appearance, number = np.unique(roots, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(appearance))[number]


def _digest(signature: np.ndarray) -> bytes | None:
    """A hash of a signature, None of an empty one; a ValueError refuses one of an earlier version."""
    if len(signature) % WIDTH:
        raise ValueError("an earlier version of W2W made the signals of these clips: make them again")
    return hashlib.blake2b(signature.tobytes()).digest() if len(signature) else None


class _Joined:
    """Clips that are one motion (union-find)."""

    def __init__(self, clips: int) -> None:
        self._parent = list(range(clips))

    def root(self, clip: int) -> int:
        """The clip that stands for all that are one with this."""
        while self._parent[clip] != clip:
            self._parent[clip] = self._parent[self._parent[clip]]
            clip = self._parent[clip]
        return clip

    def join(self, first: int, second: int) -> None:
        """Make two clips one motion."""
        self._parent[self.root(second)] = self.root(first)

    def join_equal(self, values: list) -> np.ndarray:
        """Join clips of equal values other than None; return the first clip of each value."""
        first: dict = {}
        for clip, value in enumerate(values):
            if value is not None:
                self.join(first.setdefault(value, clip), clip)
        return np.array(list(first.values()), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class _Moments:
    """Moments at which clips cross a level: level, clip, frame (M,), pose and movement as prints (M, D)."""

    level: np.ndarray
    clip: np.ndarray
    frame: np.ndarray
    prints: np.ndarray

    def some(self, which: np.ndarray | slice) -> _Moments:
        """A subset of the moments."""
        return _Moments(self.level[which], self.clip[which], self.frame[which], self.prints[which])

    @classmethod
    def joined(cls, parts: Sequence[_Moments]) -> _Moments:
        """All moments by level, within it along the first number."""
        names = ("level", "clip", "frame", "prints")
        whole = cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
        return whole.some(np.lexsort((whole.prints[:, 0], whole.level)))


def _poses(signatures: Sequence[np.ndarray], clip: int) -> np.ndarray:
    return signatures[clip].astype(np.float32).reshape(-1, WIDTH)


def _join_shared(signatures: Sequence[np.ndarray], distinct: np.ndarray, joined: _Joined) -> None:
    """Join clips that share a stretch of one motion."""
    if len(distinct) < 2:
        return
    sample = np.concatenate([_poses(signatures, clip) for clip in distinct[:: -(-len(distinct) // FOR_AXES)]])
    sample = np.concatenate([sample, mirrored_poses(sample)])
    mean = sample.mean(axis=0)
    variances, axes = np.linalg.eigh(np.cov(sample - mean, rowvar=False))
    axes, spacing = axes[:, ::-1][:, :AXES], SPACING * np.sqrt(np.maximum(variances[::-1][:LEVELLED], 1e-6))
    as_is, mirrored = [], []
    for start in range(0, len(distinct), CLIPS_AT_ONCE):
        clips = distinct[start : start + CLIPS_AT_ONCE]
        poses = [_poses(signatures, clip) for clip in clips]
        clip = np.repeat(clips, [len(part) for part in poses])
        frame = np.concatenate([np.arange(len(part)) for part in poses])
        whole = np.concatenate(poses)
        as_is.append(_moments((whole - mean) @ axes, clip, frame, spacing))
        mirrored.append(_asked(_moments((mirrored_poses(whole) - mean) @ axes, clip, frame, spacing)))
    base = _Moments.joined(as_is)
    for side, is_mirrored in ((_asked(base), False), (_Moments.joined(mirrored), True)):
        for first, second, moment, other in _candidates(side, base):
            if joined.root(first) != joined.root(second):
                one, two = (signatures[clip].reshape(-1, WIDTH) for clip in (first, second))
                if share_stretch(one, two, moment, other, is_mirrored):
                    joined.join(first, second)


def _moments(lines: np.ndarray, clip: np.ndarray, frame: np.ndarray, spacing: np.ndarray) -> _Moments:
    """Moments of clips whose poses on the axes are `lines` (F, AXES), one clip after another."""
    found = []
    inner = np.arange(AROUND, len(lines) - AROUND - 1)
    inner = inner[clip[inner - AROUND] == clip[inner + AROUND + 1]]
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
        pose = np.roll(middle, -1 - axis, axis=1) / POSES  # the axis itself says nothing more
        prints = np.concatenate([pose, movement], axis=1).astype(np.float16)
        code = (level * 2 + up) * LEVELLED + axis
        at = (frame[crossed] + share[:, 0]).astype(np.float32)
        found.append(_Moments(code.astype(np.int32), clip[crossed], at, prints))
    return _Moments.joined(found)


def _asked(moments: _Moments) -> _Moments:
    """About `ASKED` moments of each clip."""
    order = np.argsort(moments.clip, kind="stable")
    _, start, count = np.unique(moments.clip[order], return_index=True, return_counts=True)
    number = np.arange(len(order)) - np.repeat(start, count)
    return moments.some(np.sort(order[number % np.repeat(np.maximum(count // ASKED, 1), count) == 0]))


def _candidates(side: _Moments, base: _Moments) -> Iterator[tuple[int, int, float, float]]:
    """Pairs of clips with near moments, the nearest first: both clips, and the frame of each."""
    found = [np.empty((3, 0))]
    for level in np.unique(side.level):
        (one, two), (ours, theirs) = zip(
            *(_at_level(moments, level) for moments in (side, base)), strict=True
        )
        for i, j, apart in _near(one, two):
            other = side.clip[ours + i] != base.clip[theirs + j]
            found.append(np.stack([ours + i, theirs + j, apart])[:, other])
    i, j, apart = np.concatenate(found, axis=1)
    i, j = i.astype(np.int64), j.astype(np.int64)
    first, second = side.clip[i], base.clip[j]
    order = np.lexsort((apart, second, first))
    order = order[_rank([first[order], second[order]]) < TRIES]
    nearest = order[_rank([first[order], second[order]]) == 0]
    nearest = nearest[np.lexsort((apart[nearest], first[nearest]))]
    nearest = nearest[_rank([first[nearest]]) < NEAREST]
    pairs = first * (second.max(initial=0) + 1) + second
    order = order[np.isin(pairs[order], pairs[nearest])]
    for at in order[np.argsort(apart[order], kind="stable")].tolist():
        yield int(first[at]), int(second[at]), float(side.frame[i[at]]), float(base.frame[j[at]])


def _at_level(moments: _Moments, level: int) -> tuple[np.ndarray, int]:
    """Prints of the moments at one level, and the number of the first of them."""
    low, high = np.searchsorted(moments.level, [level, level + 1])
    return moments.prints[low:high].astype(np.float32), int(low)


def _rank(columns: Sequence[np.ndarray]) -> np.ndarray:
    """Place of each row among the rows before it that are equal in these columns, which are sorted."""
    number = np.arange(len(columns[0]))
    new = np.append(True, np.any([np.diff(column) != 0 for column in columns], axis=0))[: len(number)]
    return number - np.maximum.accumulate(np.where(new, number, 0)) if len(number) else number


def _near(a: np.ndarray, b: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Indices of rows of a and b that are near one another, and how far they are apart, some at a time."""
    if not len(a) or not len(b):
        return
    half_a, half_b = ((part**2).sum(axis=1) / 2 for part in (a, b))
    step = max(1, PRODUCTS // len(b))
    for start in range(0, len(a), step):
        block = slice(start, start + step)
        low, high = np.searchsorted(b[:, 0], [a[block][0, 0] - REACH, a[block][-1, 0] + REACH])
        apart = half_a[block, None] + half_b[low:high] - a[block] @ b[low:high].T
        i, j = np.divmod(np.flatnonzero(apart <= REACH**2 / 2), apart.shape[1])
        yield start + i, low + j, apart[i, j]
