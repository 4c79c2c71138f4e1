# SPDX-License-Identifier: GPL-3.0-or-later
"""Swings and twists: rotations that lay one direction on another, and turns about a direction."""

from __future__ import annotations

import numpy as np

OBTUSE = -0.5
"""Cosine below which two reflections make the rotation: they lose no digits near 180 degrees."""

OPPOSITE = 1e-15
"""Unit vectors whose sum is shorter than rounding are opposite: any axis at right angles will do."""


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) at length 1; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)


def smallest_rotation(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The rotation of least angle that turns one direction into another.

    Parameters
    ----------
    start, end : ndarray, shape (..., 3)
        Of any length but zero; broadcast against each other.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    a, b = np.broadcast_arrays(unit(start), unit(end))
    cosine = (a * b).sum(axis=-1)[..., None, None]
    skew = skew_matrix(np.cross(a, b))
    obtuse = cosine < OBTUSE
    rotation = np.eye(3) + skew + skew @ skew / np.where(obtuse, 1, 1 + cosine)
    return np.where(obtuse, _two_reflections(a, b), rotation) if obtuse.any() else rotation


def _two_reflections(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation from a to b, unit vectors far apart: a goes to b in the mirror square to b - a,
    then a mirror that holds b makes a rotation of it."""
    total = a + b
    aside = total - b * (total * b).sum(axis=-1, keepdims=True)
    opposite = np.linalg.norm(aside, axis=-1, keepdims=True) < OPPOSITE
    axis = np.cross(a, np.eye(3)[np.abs(a).argmin(axis=-1)])
    aside = unit(np.where(opposite, np.cross(axis, b), aside))
    return _mirror(aside) @ _mirror(unit(b - a))


def _mirror(normal: np.ndarray) -> np.ndarray:
    """Reflections in the planes square to unit vectors (..., 3); shape (..., 3, 3)."""
    return np.eye(3) - 2 * normal[..., :, None] * normal[..., None, :]


def turn_about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations about unit vectors (..., 3) by angles (...) in radians; shape (..., 3, 3)."""
    skew = skew_matrix(axis)
    angle = np.asarray(angle)[..., None, None]
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * (skew @ skew)


def skew_matrix(vectors: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) that multiply like the cross product with vectors (..., 3)."""
    matrix = np.zeros((*vectors.shape, 3))
    for row, column, axis, sign in ((0, 1, 2, -1), (0, 2, 1, 1), (1, 2, 0, -1)):
        matrix[..., row, column] = sign * vectors[..., axis]
        matrix[..., column, row] = -sign * vectors[..., axis]
    return matrix


def frame_of(left: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Orthonormal frames with columns left, back, up from directions (..., 3); `up` is kept, `left` made
    square to it; shape (..., 3, 3)."""
    up = unit(up)
    left = unit(left - up * (left * up).sum(axis=-1, keepdims=True))
    return np.stack([left, np.cross(up, left), up], axis=-1)
