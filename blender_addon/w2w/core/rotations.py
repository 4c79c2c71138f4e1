# SPDX-License-Identifier: GPL-3.0-or-later
"""Quaternions of rotation matrices, their turns and rates, in arrays with the component first or second."""

from __future__ import annotations

import numpy as np

RIGID_TOLERANCE = 0.01
"""Relative error up to which a matrix counts as a rotation."""

TILE_VALUES = 4096
"""Rotations worked on at once, so that their arrays stay in cache."""


def quaternions_of(matrices: np.ndarray) -> np.ndarray:
    """Unit quaternions of rotation matrices, of either sign.

    Parameters
    ----------
    matrices : ndarray, shape (T, N, 3 or 4, 3 or 4)
        Rotations, or world matrices with rotations in their upper left corner.

    Returns
    -------
    ndarray, shape (T, 4, N), float64
        w, x, y, z; NaN where the matrix holds NaN.

    Raises
    ------
    ValueError
        If a matrix carries a scale, a shear or a reflection.

    Notes
    -----
    The ten different entries of 4 q q^T are linear in R; its row with the largest diagonal gives q without
    cancellation at any angle (Shepperd 1978, doi:10.2514/3.55767b).
    """
    n_frames, n = matrices.shape[:2]
    quaternions = np.empty((n_frames, 4, n))
    step = max(1, TILE_VALUES // n)
    for start in range(0, n_frames, step):
        tile = matrices[start : start + step, :, :3, :3].transpose(2, 3, 0, 1)
        rows, wrong = _largest_row(np.ascontiguousarray(tile, dtype=np.float64))
        if wrong.any():
            frame, sensor = np.argwhere(wrong)[0]
            raise ValueError(
                f"the matrix of sensor {sensor} in frame {start + frame} is not a rigid motion: it carries "
                "a scale, a shear or a reflection; apply the object's scale before taking its matrix"
            )
        quaternions[start : start + step] = rows.transpose(1, 0, 2)
    return quaternions


def _largest_row(m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normalised row of 4 q q^T with the largest diagonal, (4, T, N), and where R was no rotation."""
    wx, wy, wz = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    xy, xz, yz = m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2]
    total, difference = m[0, 0] + m[1, 1], m[0, 0] - m[1, 1]
    above, below = 1 + m[2, 2], 1 - m[2, 2]
    q = np.stack([above + total, wx, wy, wz])
    largest = q[0].copy()
    for diagonal, row in (
        (below + difference, lambda d: (wx, d, xy, xz)),
        (below - difference, lambda d: (wy, xy, d, yz)),
        (above - total, lambda d: (wz, xz, yz, d)),
    ):
        better = diagonal > largest
        if better.any():
            for component, values in zip(q, row(diagonal), strict=True):
                component[...] = np.where(better, values, component)
            np.maximum(largest, diagonal, out=largest)
    square = dot(q, q)
    q *= 1 / np.sqrt(square)
    # of a rotation the row's square is four times its diagonal; of nothing else
    return q, np.abs(square - 4 * largest) > 4 * RIGID_TOLERANCE * largest


def unroll(quaternions: np.ndarray) -> None:
    """Give every quaternion the sign nearest to the one before it, in place; shape (T, 4, N)."""
    q = quaternions.transpose(1, 0, 2)
    turned_over = dot(q[:, 1:], q[:, :-1]) < 0
    affected = np.flatnonzero(turned_over.any(axis=0))
    if len(affected):
        signs = np.cumprod(np.where(turned_over[:, affected], -1.0, 1.0), axis=0)
        quaternions[1:, :, affected] *= signs[:, None]


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product over the first axis, of 4."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


def double_inverse(q: np.ndarray) -> np.ndarray:
    """2 / |q|^2, what turns products of a quaternion of any length into those of the unit one, doubled."""
    return 2 / dot(q, q)


def cross(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vector product over the first axis, of 3, as its three components."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def into_frame(q: np.ndarray, scale: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """World vectors in the axes of a turned frame, R^T v.

    Parameters
    ----------
    q : ndarray, shape (4, ...)
        Quaternions of any length but zero, frame to world.
    scale : ndarray, shape (...)
        Their `double_inverse`.
    v, out : ndarray, shape (3, ...)
    """
    turned = cross(q[1:], v)
    twice = cross(q[1:], turned)
    for axis in range(3):
        out[axis] = v[axis] + scale * (twice[axis] - q[0] * turned[axis])


def rate_in_frame(q: np.ndarray, scale: np.ndarray, q_dot: np.ndarray, out: np.ndarray) -> None:
    """Angular velocity in the turned frame: the vector part of 2 q^-1 q'.

    Exact for the normalised quaternion however long q is, since a change of length is q's own direction
    and falls into the scalar part.

    Parameters
    ----------
    q, q_dot : ndarray, shape (4, ...)
    scale : ndarray, shape (...)
        The `double_inverse` of q.
    out : ndarray, shape (3, ...)
    """
    turned = cross(q[1:], q_dot[1:])
    for axis in range(3):
        out[axis] = scale * (q[0] * q_dot[1 + axis] - q_dot[0] * q[1 + axis] - turned[axis])


def turn_between(q: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Rotation vector of q^-1 r, the turn from q to r in q's frame, at most pi long.

    Parameters
    ----------
    q, r : ndarray, shape (4, ...)
        Unit quaternions.

    Returns
    -------
    ndarray, shape (3, ...), rad
    """
    cosine = dot(q, r)
    turned = cross(q[1:], r[1:])
    sine = np.stack([q[0] * r[1 + axis] - r[0] * q[1 + axis] - turned[axis] for axis in range(3)])
    sine = np.where(cosine < 0, -sine, sine)
    length = np.sqrt((sine * sine).sum(axis=0))
    angle = 2 * np.arctan2(length, np.abs(cosine))
    return sine * np.divide(angle, length, out=np.full_like(length, 2.0), where=length > 0)
