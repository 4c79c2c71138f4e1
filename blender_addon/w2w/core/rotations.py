# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations as quaternions: from world matrices, their turns and rates. The component comes first."""

from __future__ import annotations

import numpy as np

RIGID_TOLERANCE = 0.01
"""Relative error up to which a matrix counts as a rotation."""

TILE_POSES = 16384
"""Poses worked on at once, so that their arrays stay in cache."""


def decompose(matrices: np.ndarray, first_sensor: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Positions and continuous unit quaternions of world matrices.

    Parameters
    ----------
    matrices : ndarray, shape (T, N, 4, 4)
    first_sensor : int
        What to call the first of them in messages.

    Returns
    -------
    positions : ndarray, shape (3, T, N), float64
    quaternions : ndarray, shape (4, T, N), float64
        w, x, y, z, each with the sign nearest to the frame before; NaN where the matrix holds NaN.

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
    positions, quaternions = np.empty((3, n_frames, n)), np.empty((4, n_frames, n))
    step = max(2, TILE_POSES // n)
    for start in range(0, n_frames, step):
        tile = slice(start, start + step)
        planes = np.ascontiguousarray(matrices[tile, :, :3].transpose(2, 3, 0, 1), dtype=np.float64)
        positions[:, tile] = planes[:, 3]
        quaternions[:, tile], wrong = _largest_row(planes)
        if wrong.any():
            frame, sensor = np.argwhere(wrong)[0]
            raise ValueError(
                f"the matrix of sensor {first_sensor + sensor} in frame {start + frame} is not a rigid "
                "motion: it carries a scale, a shear or a reflection; apply the object's scale first"
            )
        unroll(quaternions[:, max(start - 1, 0) : start + step])
    return positions, quaternions


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
    """Give every quaternion the sign nearest to the one before it, in place; shape (4, T, N)."""
    turned_over = dot(quaternions[:, 1:], quaternions[:, :-1]) < 0
    if turned_over.any():
        quaternions[:, 1:] *= np.where(np.logical_xor.accumulate(turned_over, axis=0), -1.0, 1.0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product over the first axis, of 4."""
    total = a[0] * b[0]
    for component in range(1, 4):
        total += a[component] * b[component]
    return total


def double_inverse(q: np.ndarray) -> np.ndarray:
    """2 / |q|^2, what turns products of a quaternion of any length into those of the unit one, doubled."""
    return 2 / dot(q, q)


def cross(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vector product over the first axis, of 3, as three new arrays."""
    product = a[1] * b[2], a[2] * b[0], a[0] * b[1]
    for axis in range(3):
        np.subtract(product[axis], a[axis - 1] * b[axis - 2], out=product[axis])
    return product


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
        turned[axis][...] *= q[0]
        twice[axis][...] -= turned[axis]
        twice[axis][...] *= scale
        np.add(v[axis], twice[axis], out=out[axis])


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
    turned = cross(q_dot[1:], q[1:])
    for axis, rate in enumerate(turned):
        rate += q[0] * q_dot[1 + axis]
        rate -= q_dot[0] * q[1 + axis]
        np.multiply(rate, scale, out=out[axis])


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
