# SPDX-License-Identifier: GPL-3.0-or-later
"""Find clips that show one and the same motion, so that none is tested on its own copy."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

AXES = 32
"""Principal axes on which near signatures are sought: rows that are far apart there are far apart."""

FOR_AXES = 2000
"""Signatures from which the axes are found, at most; any axes would do, these part the most pairs."""

ROWS_AT_ONCE = 2000
"""Signatures put side by side at a time: all of them would double their memory, mirrored ones again."""

PRODUCTS = 4_000_000
"""Products of projections held at a time, 32 MB."""

PAIRS_AT_ONCE = 2_000
"""Pairs whose distance is computed at a time."""


def same_motion_groups(
    clips: Sequence[str],
    keys: Sequence[str] | None = None,
    signatures: Sequence[np.ndarray] | None = None,
    tolerance: float = 0.05,
    mirrored: Callable[[np.ndarray], np.ndarray] | None = None,
    alike: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    columns: np.ndarray | None = None,
) -> np.ndarray:
    """Number the distinct motions among C clips, in order of appearance, shape (C,), int.

    Two clips are the same when their names or keys are equal or their signatures nearly are, and
    sameness is passed on: if a equals b and b equals c, all three are one. An empty key or signature says
    nothing.

    Parameters
    ----------
    signatures : sequence of ndarrays (K,), length C, optional
        Description of each clip's motion, such as `motion_signature` gives.
    tolerance : float
        Greatest root mean square difference of two signatures of one motion, in units
        of each column's standard deviation over the clips.
    mirrored : callable, optional
        Exchanges left and right of signatures (M, K): libraries hold the same motion mirrored,
        and a mirrored copy made to train on would be the very clip tested.
    alike : callable, optional
        Says which of the pairs of signatures (M, K), (M, K) within the tolerance are one motion after all.
    columns : ndarray of bool, shape (K,), optional
        Those that the tolerance is about; all by default.
    """
    edges = [_equal_pairs(list(clips))]
    if keys is not None:
        edges.append(_equal_pairs([key or None for key in keys]))
    if signatures is not None:
        digests = [hashlib.blake2b(row.tobytes()).digest() if len(row) else None for row in signatures]
        equal = _equal_pairs(digests)
        edges += [equal, _near_pairs(signatures, np.unique(equal[0]), tolerance, mirrored, alike, columns)]
    first, second = np.concatenate(edges, axis=1)
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(clips), len(clips)))
    _, component = connected_components(graph, directed=False)
    _, appearance, number = np.unique(component, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(appearance))[number]


def _equal_pairs(values: list) -> np.ndarray:
    """Link each value other than None to its first occurrence: indices (2, M)."""
    first: dict = {}
    links = [(first.setdefault(value, i), i) for i, value in enumerate(values) if value is not None]
    return np.array(links, dtype=np.int64).reshape(-1, 2).T


@dataclass(frozen=True, eq=False)
class _Rows:
    """Some of the signatures, as they are or mirrored, put side by side (L, K) as they are asked for."""

    signatures: Sequence[np.ndarray]
    numbers: np.ndarray
    mirrored: Callable[[np.ndarray], np.ndarray] | None = None

    def some(self, which: np.ndarray | slice) -> np.ndarray:
        """Those of these places among `numbers`."""
        rows = np.array([self.signatures[number] for number in self.numbers[which].tolist()])
        return rows if self.mirrored is None else self.mirrored(rows)

    def blocks(self) -> Iterator[np.ndarray]:
        """All of them, `ROWS_AT_ONCE` at a time."""
        for start in range(0, len(self.numbers), ROWS_AT_ONCE):
            yield self.some(slice(start, start + ROWS_AT_ONCE))

    def deviation(self) -> np.ndarray:
        """Standard deviation of each column, shape (K,)."""
        mean = sum(rows.sum(axis=0, dtype=np.float64) for rows in self.blocks()) / len(self.numbers)
        square = sum(((rows - mean) ** 2).sum(axis=0) for rows in self.blocks())
        return np.sqrt(square / len(self.numbers))


@dataclass(frozen=True, eq=False)
class _Projected:
    """Rows on a few axes, along the first of them in order."""

    rows: _Rows
    order: np.ndarray  # (L,), int: which of the rows each line is of
    lines: np.ndarray  # (L, AXES), in double precision, however the rows are held

    @classmethod
    def of(cls, rows: _Rows, axes: np.ndarray) -> _Projected:
        """Rows on axes (K, AXES)."""
        lines = np.concatenate([block.astype(np.float64) @ axes for block in rows.blocks()])
        order = np.argsort(lines[:, 0])
        return cls(rows, order, lines[order])


@dataclass(frozen=True, eq=False)
class _Nearness:
    """When two rows are one motion: columns times `scale` no further apart than `reach`, and `alike`."""

    scale: np.ndarray
    reach: float
    alike: Callable[[np.ndarray, np.ndarray], np.ndarray] | None

    def of(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Which of the pairs are, shape (L,)."""
        near = np.linalg.norm((first - second) * self.scale, axis=1) <= self.reach
        if self.alike is not None:
            near[near] = self.alike(first[near], second[near])
        return near


def _near_pairs(
    signatures: Sequence[np.ndarray],
    distinct: np.ndarray,
    tolerance: float,
    mirrored: Callable[[np.ndarray], np.ndarray] | None,
    alike: Callable[[np.ndarray, np.ndarray], np.ndarray] | None,
    columns: np.ndarray | None,
) -> np.ndarray:
    """Index pairs (2, M) of distinct rows that differ by at most `tolerance`, columns standardised, and are
    `alike`; of rows and mirrored rows too, where they can be mirrored."""
    if not len(distinct):
        return np.empty((2, 0), dtype=np.int64)
    told = np.array([number for number, row in enumerate(signatures) if len(row)])
    deviation = _Rows(signatures, told).deviation()
    used = deviation > 0 if columns is None else columns & (deviation > 0)
    scale = np.divide(1.0, deviation, where=used, out=np.zeros_like(deviation))
    nearness = _Nearness(scale, tolerance * np.sqrt(used.sum()), alike)
    rows = _Rows(signatures, distinct)
    for_axes = rows.some(slice(None, None, -(-len(distinct) // FOR_AXES)))[:, used] * scale[used]
    centred = for_axes - for_axes.mean(axis=0)
    principal = np.linalg.eigh(centred.T @ centred)[1][:, ::-1][:, :AXES]  # the greatest first
    axes = np.zeros((len(scale), AXES))
    axes[used, : min(AXES, used.sum())] = scale[used, None] * principal
    own = _Projected.of(rows, axes)
    pairs = [*_pairs_within(own, own, nearness)]
    if mirrored is not None:
        pairs += _pairs_within(_Projected.of(_Rows(signatures, distinct, mirrored), axes), own, nearness)
    return distinct[np.concatenate(pairs, axis=1)] if pairs else np.empty((2, 0), dtype=np.int64)


def _pairs_within(one: _Projected, other: _Projected, nearness: _Nearness) -> Iterator[np.ndarray]:
    """Index pairs (2, M) of near rows of two kinds, some at a time."""
    a, b = one.lines, other.lines
    half_a, half_b = ((part**2).sum(axis=1) / 2 for part in (a, b))
    far = nearness.reach * (1 + 1e-6) + 1e-9  # of projections, which are no longer than what they are of
    step = max(1, PRODUCTS // len(b))
    for start in range(0, len(a), step):
        block = slice(start, start + step)
        low, high = np.searchsorted(b[:, 0], [a[block][0, 0] - far, a[block][-1, 0] + far])
        near = a[block] @ b[low:high].T - half_b[low:high] >= half_a[block, None] - far**2 / 2
        i, j = np.nonzero(near)
        yield _within(one.rows, other.rows, one.order[start + i], other.order[low + j], nearness)


def _within(one: _Rows, other: _Rows, i: np.ndarray, j: np.ndarray, nearness: _Nearness) -> np.ndarray:
    """Those of the pairs that are near, shape (2, L)."""
    near = np.empty(len(i), dtype=bool)
    for start in range(0, len(i), PAIRS_AT_ONCE):
        block = slice(start, start + PAIRS_AT_ONCE)
        near[block] = nearness.of(one.some(i[block]), other.some(j[block]))
    return np.stack([i[near], j[near]])
