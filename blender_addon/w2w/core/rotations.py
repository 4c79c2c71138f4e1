# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations as quaternions: from world matrices, their turns and rates. The component comes first."""

import numpy as np

RIGID_TOLERANCE = 0.01
"""Relative error up to which a matrix counts as a rotation."""

TILE_POSES = 16384
"""Poses worked on at once, so that their arrays stay in cache."""

TILE_MATRICES = 2048
"""Matrices taken apart at once: each entry is one more pass over them."""

SMALL_ANGLE = 1e-3
"""Angle, radians, up to which a series gives its ratio to the sine of its half."""


def decompose(matrices: np.ndarray, first_sensor: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Positions (3, T, N) and continuous unit quaternions (4, T, N), float64, of world matrices (T, N, 4, 4).

    Quaternions are w, x, y, z, each with the sign nearest to the frame before; NaN if the matrix holds
    NaN. The ten different entries of 4 q q^T are linear in R; its row with the largest diagonal gives q
    without cancellation at any angle (Shepperd 1978, doi:10.2514/3.55767b).

    Raises ValueError if a matrix carries a scale, a shear or a reflection; the message counts sensors from
    `first_sensor`.
    """
    n_frames, n = matrices.shape[:2]
    positions, quaternions = np.empty((3, n_frames, n)), np.empty((4, n_frames, n))
    step = max(2, TILE_POSES // n)
    for start in range(0, n_frames, step):
        tile = slice(start, start + step)
        planes = _planes(matrices[tile])
        positions[:, tile] = planes[:, 3]
        wrong = _largest_row(planes, quaternions[:, tile])
        if wrong.any():
            frame, sensor = np.argwhere(wrong)[0]
            raise ValueError(
                f"the matrix of sensor {first_sensor + sensor} in frame {start + frame} is not a rigid "
                "motion: it carries a scale, a shear or a reflection; apply the object's scale first"
            )
        unroll(quaternions[:, max(start - 1, 0) : start + step])
    return positions, quaternions


def continuous_quaternions(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions w, x, y, z (4, T, N), float64, of rotations (T, N, 3, 3), as `decompose` finds them.

    Raises ValueError if a matrix is not a rotation.
    """
    quaternions = np.empty((4, *rotations.shape[:2]))
    if _largest_row(np.ascontiguousarray(rotations.transpose(2, 3, 0, 1)), quaternions).any():
        raise ValueError("a matrix is no rotation: it carries a scale, a shear or a reflection")
    unroll(quaternions)
    return quaternions


def rotation_vectors(rotations: np.ndarray) -> np.ndarray:
    """Rotation vectors (..., 3), radians, float64, of rotations (..., 3, 3).

    They are SciPy's, in the same steps, but for all at once: in half the time or less.
    """
    r = np.ascontiguousarray(rotations.reshape(-1, 3, 3).transpose(1, 2, 0), dtype=np.float64)
    trace, q = r[0, 0] + r[1, 1] + r[2, 2], np.empty((4, 4, r.shape[2]))  # by largest component: x, y, z, w
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        q[i, i] = 1 - trace + 2 * r[i, i]
        q[i, j] = q[j, i] = r[j, i] + r[i, j]
        q[i, 3] = q[3, i] = r[k, j] - r[j, k]
    q[3, 3] = 1 + trace
    largest = np.stack([r[0, 0], r[1, 1], r[2, 2], trace]).argmax(axis=0)
    x, y, z, w = np.take_along_axis(q, largest[None, None], axis=0)[0]
    leading = np.where(w, w, np.where(x, x, np.where(y, y, z)))  # half a turn goes the way of its first axis
    norm = np.copysign(np.sqrt(x * x + y * y + z * z + w * w), leading)
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    angle = 2 * np.arctan2(np.sqrt(x * x + y * y + z * z), w)
    square, half = angle * angle, np.sin(np.maximum(angle, SMALL_ANGLE) / 2)
    times = np.where(angle <= SMALL_ANGLE, 2 + square / 12 + 7 * square * square / 2880, angle / half)
    return np.stack([times * x, times * y, times * z], axis=-1).reshape(rotations.shape[:-1])


def in_axes(rotations: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Rotations R (T, N, 3, 3) in other axes A, as A^T R A; A is (3, 3) or (N, 3, 3), an axis a column."""
    # one large product: numpy takes many small ones one by one
    change = np.einsum("...ca,...db->...cdab", axes, axes).reshape(*axes.shape[:-2], 9, 9)
    entries = rotations.reshape(*rotations.shape[:2], 9).swapaxes(0, 1) @ change
    return entries.swapaxes(0, 1).reshape(rotations.shape)


def _planes(matrices: np.ndarray) -> np.ndarray:
    """Matrices (T, N, 4, 4) entry by entry, (3, 4, T, N), doubles; a view if they lie so already."""
    if matrices.dtype == np.float64 and matrices.strides[1] == matrices.itemsize:
        return matrices[:, :, :3].transpose(2, 3, 0, 1)
    n_frames, n = matrices.shape[:2]
    planes = np.empty((3, 4, n_frames, n))
    step = max(1, TILE_MATRICES // n)
    for start in range(0, n_frames, step):
        part = slice(start, start + step)
        planes[:, :, part] = matrices[part, :, :3].transpose(2, 3, 0, 1)
    return planes


def _largest_row(r: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Write the normalised row of 4 q q^T with the largest diagonal to `out`, (4, T, N).

    Returns where R was no rotation, (T, N).
    """
    m = _outer_square(r)
    q, largest = m[0], m[0, 0]
    for row in range(1, 4):
        better = m[row, row] > largest
        if better.any():
            q, largest = np.where(better, m[row], q), np.where(better, m[row, row], largest)
    square = dot(q, q)
    np.multiply(q, 1 / np.sqrt(square), out=out)
    # of a rotation the row's square is four times its diagonal; of nothing else
    largest = 4 * largest
    wrong: np.ndarray = np.abs(square - largest) > RIGID_TOLERANCE * largest
    return wrong


def _outer_square(r: np.ndarray) -> np.ndarray:
    """4 q q^T of rotation matrices, (3, 3 or more, T, N) -> (4, 4, T, N)."""
    m = np.empty((4, 4, *r.shape[2:]))
    total, difference = r[0, 0] + r[1, 1], r[0, 0] - r[1, 1]
    above, below = 1 + r[2, 2], 1 - r[2, 2]
    np.add(above, total, out=m[0, 0])
    np.add(below, difference, out=m[1, 1])
    np.subtract(below, difference, out=m[2, 2])
    np.subtract(above, total, out=m[3, 3])
    for axis, (i, j) in enumerate(((2, 1), (0, 2), (1, 0)), start=1):
        np.subtract(r[i, j], r[j, i], out=m[0, axis])
        np.add(r[i, j], r[j, i], out=m[i + 1, j + 1])
        m[j + 1, i + 1], m[axis, 0] = m[i + 1, j + 1], m[0, axis]
    return m


def unroll(quaternions: np.ndarray) -> None:
    """Give every quaternion the sign nearest to the one before it, in place; shape (4, T, N)."""
    turned_over = dot(quaternions[:, 1:], quaternions[:, :-1]) < 0
    if turned_over.any():
        quaternions[:, 1:] *= 1.0 - 2.0 * np.logical_xor.accumulate(turned_over, axis=0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product over the first axis."""
    product: np.ndarray = np.einsum("a...,a...->...", a, b)  # in two thirds of the time of a sum of products
    return product


def double_inverse(q: np.ndarray) -> np.ndarray:
    """2 / |q|^2, what turns products of a quaternion of any length into those of the unit one, doubled."""
    return 2 / dot(q, q)


def cross(a: np.ndarray, b: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """Vector product of vectors (3, ...), one component after the other: nothing is copied."""
    out = np.empty_like(b) if out is None else out
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        np.multiply(a[second], b[third], out=out[axis, ...])
        out[axis] -= a[third] * b[second]
    return out


def into_frame(q: np.ndarray, scale: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """World vectors `v` (3, ...) in the axes of a turned frame, R^T v.

    The quaternions (4, ...), frame to world, may have any length but zero; `scale` is their `double_inverse`.
    """
    turned = cross(q[1:], v)
    twice = cross(q[1:], turned)
    turned *= q[0]
    twice -= turned
    twice *= scale
    np.add(v, twice, out=out)


def rate_in_frame(q: np.ndarray, scale: np.ndarray, q_dot: np.ndarray, out: np.ndarray) -> None:
    """Angular velocity (3, ...) in the turned frame: the vector part of 2 q^-1 q'.

    Exact for the normalised quaternion however long q (4, ...) is, since a change of length is q's own
    direction and falls into the scalar part. `scale` is the `double_inverse` of q.
    """
    rate = cross(q_dot[1:], q[1:])
    rate += q[0] * q_dot[1:]
    rate -= q_dot[0] * q[1:]
    np.multiply(rate, scale, out=out)


OBTUSE = -0.5
"""Cosine below which two reflections make the rotation: they lose no digits near 180 degrees."""

OPPOSITE = 1e-15
"""Unit vectors whose sum is shorter than rounding are opposite: any axis at right angles will do."""


def length(vectors: np.ndarray) -> np.ndarray:
    """Lengths (...) of vectors (..., 3), as `np.linalg.norm` has them, in a third of its time."""
    x, y, z = (vectors[..., axis] for axis in range(3))
    lengths: np.ndarray = np.sqrt(x * x + y * y + z * z)
    return lengths


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) at length 1; zero vectors stay zero."""
    lengths = length(vectors)[..., None]
    return vectors / np.where(lengths > 0, lengths, 1)


def smallest_rotation(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotations (..., 3, 3) of least angle from one direction (..., 3) to another, of any length but zero."""
    a, b = np.broadcast_arrays(unit(start), unit(end))
    cosine = (a * b).sum(axis=-1)[..., None, None]
    skew = skew_matrix(cross(a.T, b.T).T)
    obtuse = cosine < OBTUSE
    rotation = np.eye(3) + skew + skew @ skew / np.where(obtuse, 1, 1 + cosine)
    return np.where(obtuse, _two_reflections(a, b), rotation) if obtuse.any() else rotation


def _two_reflections(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation from a to b, unit vectors far apart.

    a goes to b in the mirror square to b - a; a mirror that holds b then makes a rotation of it.
    """
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
    matrix[..., (2, 0, 1), (1, 2, 0)] = vectors
    matrix[..., (1, 2, 0), (2, 0, 1)] = -vectors
    return matrix


def frame_of(left: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Orthonormal frames (..., 3, 3) with columns left, back, up from directions (..., 3).

    `up` is kept, `left` made square to it.
    """
    up = unit(up)
    left = unit(left - up * (left * up).sum(axis=-1, keepdims=True))
    return np.stack([left, np.cross(up, left), up], axis=-1)
