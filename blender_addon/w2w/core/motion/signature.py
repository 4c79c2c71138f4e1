# SPDX-License-Identifier: GPL-3.0-or-later
"""Signatures by which motions are compared, free of body and heading, and moments to find near ones by."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from ..body.body import JOINT_INDEX, MIRRORED_JOINTS
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


def motion_signature(motion: Motion) -> np.ndarray:
    """Smoothed poses at `RATE`, independent of body and heading, shape (n * WIDTH,), float16.

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


REACH = 0.8
"""Greatest distance, in these units, of moments that are looked at closely."""

ASKED = 8
"""Moments of a clip for which near ones are sought, about; in the others it is found."""

CLOSEST = 4
"""Moments that are found for one, at most."""

NEAREST, TRIES = 4, 2
"""Nearest clips with which a clip is compared, and nearest moments of both at which they are, at most."""

CELL = 1000.0
"""Distance of cells' numbers; prints' own are far below."""

FIRST = 10
"""Principal axes of prints along which most are told to be far apart already."""

ROUNDING = 1e-3
"""Half of a squared distance that single precision may be off."""

ROWS_AT_ONCE = 128
"""Moments for which near ones are sought at a time: so few lie close together."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Arrays of equal length."""

    def some(self, which: np.ndarray | slice) -> Self:
        """A subset of the rows."""
        return replace(self, **{column.name: getattr(self, column.name)[which] for column in fields(self)})


@dataclass(frozen=True, eq=False)
class Moments(Columns):
    """Moments of one level each: level, clip, frame (M,), and what is like it in copies as prints (M, D)."""

    level: np.ndarray
    clip: np.ndarray
    frame: np.ndarray
    prints: np.ndarray

    @classmethod
    def joined(cls, parts: list[Moments]) -> Moments:
        """All moments by level, within it by the cells of `_cells`; takes the parts out of their list."""
        columns = {name: [getattr(part, name) for part in parts] for name in cls.__annotations__}
        parts.clear()  # so that no moment is held twice
        whole = {name: np.concatenate(columns.pop(name)) for name in cls.__annotations__}
        order = np.lexsort((_cells(whole["prints"]), whole["level"]))
        return cls(**{name: whole.pop(name)[order] for name in cls.__annotations__})


def few_of_each(moments: Moments) -> Moments:
    """About `ASKED` moments of each clip, evenly taken."""
    order = np.argsort(moments.clip, kind="stable")
    _, start, count = np.unique(moments.clip[order], return_index=True, return_counts=True)
    place = np.arange(len(order)) - np.repeat(start, count)
    return moments.some(np.sort(order[place % np.repeat(np.maximum(count // ASKED, 1), count) == 0]))


@dataclass(frozen=True, eq=False)
class Pairs(Columns):
    """Pairs of clips (C,) and the frame of each at which they may show one motion, (C,)."""

    first: np.ndarray
    second: np.ndarray
    moment: np.ndarray
    other: np.ndarray


def candidates(side: Moments, base: Moments) -> Pairs:
    """Pairs of clips with near moments, by the first."""
    found: list[tuple[np.ndarray, ...]] = [(np.empty(0, np.int32),) * 2 + (np.empty(0, np.float32),)]
    for level in np.unique(side.level):
        (one, two), (ours, theirs) = zip(
            *(_at_level(moments, level) for moments in (side, base)), strict=True
        )
        for i, j, apart in _near(one, two) if len(two) else ():
            other = np.flatnonzero(side.clip[ours + i] != base.clip[theirs + j])
            pair = ((ours + i[other]).astype(np.int32), (theirs + j[other]).astype(np.int32))
            found.append((*pair, apart[other]))
    i, j, apart = (np.concatenate(part) for part in zip(*found, strict=True))
    first, second = side.clip[i], base.clip[j]
    order = np.lexsort((apart, second, first))
    order = order[_rank([first[order], second[order]]) < TRIES]
    nearest = order[_rank([first[order], second[order]]) == 0]
    nearest = nearest[np.lexsort((apart[nearest], first[nearest]))]
    nearest = nearest[_rank([first[nearest]]) < NEAREST]
    pairs = first.astype(np.int64) * (second.max(initial=0) + 1) + second
    order = order[np.isin(pairs[order], pairs[nearest])]
    return Pairs(first[order], second[order], side.frame[i[order]], base.frame[j[order]])


def _at_level(moments: Moments, level: int) -> tuple[np.ndarray, int]:
    """Prints of the moments at one level, and the number of the first of them."""
    low, high = np.searchsorted(moments.level, [level, level + 1])
    return moments.prints[low:high].astype(np.float32), int(low)


def _rank(columns: Sequence[np.ndarray]) -> np.ndarray:
    """Place of each row among the rows before it that are equal in these columns, which are sorted."""
    number = np.arange(len(columns[0]))
    new = np.append(True, np.any([np.diff(column) != 0 for column in columns], axis=0))[: len(number)]
    return number - np.maximum.accumulate(np.where(new, number, 0)) if len(number) else number


def _cells(prints: np.ndarray) -> np.ndarray:
    """Place of each print (M, D) in cells of `REACH` along its first number, and inside along its second."""
    return CELL * np.floor(prints[:, 0].astype(np.float64) / REACH) + prints[:, 1]


def _near(a: np.ndarray, b: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Indices of rows of a and b that are near one another, and how far they are apart, some at a time.

    Of each row of a the closest of b in a cell of `REACH` along the first number alone.
    """
    cell_of = np.floor(b[:, 0] / REACH)
    about = b - b.mean(axis=0)
    axes = np.linalg.eigh(about.T @ about)[1][:, ::-1].copy()  # along the first most are far apart
    a, b = a @ axes, b @ axes
    cells_a, cells_b = _cells(a), _cells(b)
    row_a, row_b = np.argsort(cells_a), np.argsort(cells_b)
    a, b, cells_a, cells_b = a[row_a], b[row_b], cells_a[row_a], cells_b[row_b]
    few_a, few_b = a[:, :FIRST], b[:, :FIRST]
    half_a, half_b = ((few**2).sum(axis=1, keepdims=True) / 2 for few in (few_a, few_b))
    # so that a product is how much nearer than REACH they are along the first axes
    few_a = np.concatenate([few_a, REACH**2 / 2 + ROUNDING - half_a, -np.ones_like(half_a)], axis=1)
    few_b = np.concatenate([few_b, np.ones_like(half_b), half_b], axis=1).T
    ends = np.append(np.flatnonzero(np.diff(np.round(cells_a / CELL))) + 1, len(a))
    for first, last in zip(np.append(0, ends[:-1]), ends, strict=True):
        for start in range(first, last, ROWS_AT_ONCE):
            block, found = slice(start, min(start + ROWS_AT_ONCE, last)), []
            for by in (-CELL, 0, CELL):
                low, high = np.searchsorted(cells_b, cells_a[[start, block.stop - 1]] + by + [-REACH, REACH])
                near = np.flatnonzero(few_a[block] @ few_b[:, low:high] >= 0)
                found.append(np.divmod(near, max(high - low, 1)) + np.array([[start], [low]]))
            i, j = np.concatenate(found, axis=1)
            apart = np.linalg.norm(a[i] - b[j], axis=1)
            i, j, apart = row_a[i[apart <= REACH]], row_b[j[apart <= REACH]], apart[apart <= REACH]
            order = np.lexsort((apart, cell_of[j], i))
            order = order[_rank([i[order], cell_of[j[order]]]) < CLOSEST]
            yield i[order], j[order], apart[order]
