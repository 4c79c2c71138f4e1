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

    def on(self, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lines (L, AXES) on axes (K, AXES), along the first of them, and which of the rows each is of."""
        lines = np.concatenate([block.astype(np.float64) @ axes for block in self.blocks()])
        order = np.argsort(lines[:, 0])
        return lines[order], order


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
    found = [np.empty((2, 0), dtype=np.int64)]
    if not len(distinct):
        return found[0]
    told = _Rows(signatures, np.array([number for number, row in enumerate(signatures) if len(row)]))
    mean = sum(rows.sum(axis=0, dtype=np.float64) for rows in told.blocks()) / len(told.numbers)
    square = sum(((rows - mean) ** 2).sum(axis=0) for rows in told.blocks())
    deviation = np.sqrt(square / len(told.numbers))
    used = deviation > 0 if columns is None else columns & (deviation > 0)
    scale = np.divide(1.0, deviation, where=used, out=np.zeros_like(deviation))
    reach = tolerance * np.sqrt(used.sum())
    rows = _Rows(signatures, distinct)
    axes = _principal_axes(rows.some(slice(None, None, -(-len(distinct) // FOR_AXES))), used, scale)
    lines, order = rows.on(axes)
    for side in [rows] if mirrored is None else [rows, _Rows(signatures, distinct, mirrored)]:
        side_lines, side_order = (lines, order) if side is rows else side.on(axes)
        for i, j in _pairs_on_axes(side_lines, lines, reach):
            i, j = side_order[i], order[j]
            for start in range(0, len(i), PAIRS_AT_ONCE):
                some = slice(start, start + PAIRS_AT_ONCE)
                one, other = side.some(i[some]), rows.some(j[some])
                near = np.linalg.norm((one - other) * scale, axis=1) <= reach
                if alike is not None:
                    near[near] = alike(one[near], other[near])
                found.append(np.stack([i[some][near], j[some][near]]))
    return distinct[np.concatenate(found, axis=1)]


def _principal_axes(rows: np.ndarray, used: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Axes (K, AXES) of rows (L, K) times `scale` (K,), of the columns that are used, (K,) of bool."""
    scaled = rows[:, used] * scale[used]
    centred = scaled - scaled.mean(axis=0)
    principal = np.linalg.eigh(centred.T @ centred)[1][:, ::-1][:, :AXES]  # the greatest first
    axes = np.zeros((len(scale), AXES))
    axes[used, : min(AXES, used.sum())] = scale[used, None] * principal
    return axes


def _pairs_on_axes(a: np.ndarray, b: np.ndarray, reach: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Indices of lines (L, AXES) that are near one another, some at a time."""
    half_a, half_b = ((part**2).sum(axis=1) / 2 for part in (a, b))
    far = reach * (1 + 1e-6) + 1e-9  # of projections, which are no longer than what they are of
    step = max(1, PRODUCTS // len(b))
    ends_a, ends_b = np.column_stack([a, -np.ones(len(a))]), np.column_stack([b, half_b])
    for start in range(0, len(a), step):
        block = slice(start, start + step)
        low, high = np.searchsorted(b[:, 0], [a[block][0, 0] - far, a[block][-1, 0] + far])
        near = ends_a[block] @ ends_b[low:high].T >= half_a[block, None] - far**2 / 2
        i, j = np.divmod(np.flatnonzero(near), near.shape[1])  # hardly any are: quicker than np.nonzero
        yield start + i, low + j
