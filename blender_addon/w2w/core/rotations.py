# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation matrices to quaternions that stay continuous in time."""

from __future__ import annotations

import numpy as np

RIGID_TOLERANCE = 0.01


def continuous_quaternions(matrices: np.ndarray) -> np.ndarray:
    """Unit quaternions of rotation matrices, with the sign nearest to the frame before.

    Parameters
    ----------
    matrices : ndarray, shape (T, N, 3 or 4, 3 or 4)
        Rotations, or world matrices with rotations in their upper left corner.

    Returns
    -------
    ndarray, shape (T, 4, N), float64
        w, x, y, z; ready for component-wise splines.

    Raises
    ------
    ValueError
        If a matrix carries a scale, a shear or a reflection.

    Notes
    -----
    The ten entries of K = 4 q q^T are linear in R; the row with the largest diagonal gives q without
    cancellation (Shepperd 1978, doi:10.2514/3.55767b).
    """
    m = np.ascontiguousarray(matrices[:, :, :3, :3].transpose(2, 3, 0, 1), dtype=np.float64)
    xx, yy, zz = m[0, 0], m[1, 1], m[2, 2]
    wx, wy, wz = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    xy, xz, yz = m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2]
    q = np.empty((len(matrices), 4, matrices.shape[1]))
    largest = 1 + xx + yy + zz
    _set_row(q, True, largest, wx, wy, wz)
    for diagonal, row in (
        (1 + xx - yy - zz, lambda d: (wx, d, xy, xz)),
        (1 - xx + yy - zz, lambda d: (wy, xy, d, yz)),
        (1 - xx - yy + zz, lambda d: (wz, xz, yz, d)),
    ):
        better = diagonal > largest
        _set_row(q, better, *row(diagonal))
        np.copyto(largest, diagonal, where=better)
    square = np.einsum("tcn,tcn->tn", q, q)
    _check_rigid(square, largest)
    q /= np.sqrt(square)[:, None]
    flips = np.where(np.einsum("tcn,tcn->tn", q[1:], q[:-1]) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(flips, axis=0)[:, None]
    return q


def _set_row(q: np.ndarray, where: np.ndarray | bool, *row: np.ndarray) -> None:
    for component, values in enumerate(row):
        np.copyto(q[:, component], values, where=where)


def _check_rigid(square: np.ndarray, largest: np.ndarray) -> None:
    """A row of 4 q q^T has the square 4 times its diagonal; nothing but a rotation does."""
    wrong = np.abs(square - 4 * largest) > RIGID_TOLERANCE * 4 * largest
    if wrong.any():
        frame, sensor = np.argwhere(wrong)[0]
        raise ValueError(
            f"the matrix of sensor {sensor} in frame {frame} is not a rigid motion: "
            "it carries a scale, a shear or a reflection; apply the object's scale first"
        )
