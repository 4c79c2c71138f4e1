# SPDX-License-Identifier: GPL-3.0-or-later
"""Find clips that show one and the same motion, so that none is tested on what it was trained on."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

AXES = 32
"""Principal axes on which near signatures are sought: rows that are far apart there are far apart."""

FOR_AXES = 2000
"""Signatures that tell the axes, at most; any axes would do, these part the most pairs."""

PRODUCTS = 4_000_000
"""Products of projections held at a time, 32 MB."""

PAIRS_AT_ONCE = 2_000
"""Pairs whose distance is told at a time."""


def same_motion_groups(
    clips: Sequence[str],
    keys: Sequence[str] | None = None,
    signatures: np.ndarray | None = None,
    tolerance: float = 0.05,
    mirrored: np.ndarray | None = None,
) -> np.ndarray:
    """Number the distinct motions among clips: downloads of one motion get one number.

    Two clips are the same when their keys are equal or their signatures nearly are, and
    sameness is passed on: if a equals b and b equals c, all three are one.

    Parameters
    ----------
    clips : sequence of str, length C
        Name of each clip; clips of equal name are the same.
    keys : sequence of str, optional
        Known identity of each clip's motion; an empty key says nothing.
    signatures : ndarray, shape (C, K), optional
        Description of each clip's motion, such as `motion_signature` gives.
    tolerance : float
        Greatest root mean square difference of two signatures of one motion, in units
        of each column's standard deviation over the clips.
    mirrored : ndarray, shape (C, K), optional
        The signatures with left and right exchanged: libraries hold the same motion mirrored,
        and a mirrored copy made to train on would be the very clip tested.

    Returns
    -------
    ndarray, shape (C,), int
        Groups in order of first appearance.
    """
    edges = [_equal_pairs(list(clips))]
    if keys is not None:
        edges.append(_equal_pairs([key or None for key in keys]))
    if signatures is not None:
        signatures = np.asarray(signatures)
        alike = _equal_pairs([hashlib.blake2b(row.tobytes(), digest_size=16).digest() for row in signatures])
        edges += [alike, _near_pairs(signatures, mirrored, np.unique(alike[0]), tolerance)]
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


def _near_pairs(
    signatures: np.ndarray, mirrored: np.ndarray | None, distinct: np.ndarray, tolerance: float
) -> np.ndarray:
    """Index pairs (2, M) of distinct rows that differ by at most `tolerance`, columns standardised; of rows
    and mirrored rows too, where given."""
    deviation = signatures.std(axis=0, dtype=np.float64)
    used = deviation > 0
    scale = np.divide(1.0, deviation, where=used, out=np.zeros_like(deviation))
    reach = tolerance * np.sqrt(used.sum())
    every = len(distinct) == len(signatures)
    own, *other = (rows if every else rows[distinct] for rows in (signatures, mirrored) if rows is not None)
    pairs = [*_pairs_within(own, own, scale, reach)]
    for rows in other:
        pairs += _pairs_within(rows, own, scale, reach)
    return distinct[np.concatenate(pairs, axis=1)] if pairs else np.empty((2, 0), dtype=np.int64)


def _pairs_within(
    one: np.ndarray, other: np.ndarray, scale: np.ndarray, reach: float
) -> Iterator[np.ndarray]:
    """Index pairs (2, M) of rows (C, K) of two kinds no further apart than `reach`, some at a time."""
    axes = scale[:, None] * _principal_axes(other[:: -(-len(other) // FOR_AXES)] * scale)
    a, b = _projected(one, axes), _projected(other, axes)
    rows, among = np.argsort(a[:, 0]), np.argsort(b[:, 0])
    a, b = a[rows], b[among]
    half_a, half_b = ((part**2).sum(axis=1) / 2 for part in (a, b))
    far = reach * (1 + 1e-6) + 1e-9  # of projections, which are no longer than what they are of
    step = max(1, PRODUCTS // len(b))
    for start in range(0, len(a), step):
        block = slice(start, start + step)
        low, high = np.searchsorted(b[:, 0], [a[block][0, 0] - far, a[block][-1, 0] + far])
        near = a[block] @ b[low:high].T - half_b[low:high] >= half_a[block, None] - far**2 / 2
        i, j = np.nonzero(near)
        yield _within(one, other, rows[start + i], among[low + j], scale, reach)


def _projected(rows: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Rows (C, K) on axes (K, A) in double precision, however they are held, shape (C, A)."""
    steps = range(0, len(rows), FOR_AXES)
    return np.concatenate([rows[start : start + FOR_AXES].astype(np.float64) @ axes for start in steps])


def _principal_axes(rows: np.ndarray) -> np.ndarray:
    """Directions (K, `AXES`) along which rows (C, K) differ most, the greatest first."""
    centred = rows - rows.mean(axis=0)
    return np.linalg.eigh(centred.T @ centred)[1][:, ::-1][:, :AXES]


def _within(
    one: np.ndarray, other: np.ndarray, i: np.ndarray, j: np.ndarray, scale: np.ndarray, reach: float
) -> np.ndarray:
    """Those of the pairs that are no further apart than `reach`, shape (2, L)."""
    near = np.empty(len(i), dtype=bool)
    for start in range(0, len(i), PAIRS_AT_ONCE):
        some = slice(start, start + PAIRS_AT_ONCE)
        near[some] = np.linalg.norm((one[i[some]] - other[j[some]]) * scale, axis=1) <= reach
    return np.stack([i[near], j[near]])
