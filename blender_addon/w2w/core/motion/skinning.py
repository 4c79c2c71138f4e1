# SPDX-License-Identifier: GPL-3.0-or-later
"""Forward kinematics and linear blend skinning, only for the vertices asked for."""

from __future__ import annotations

import numpy as np

from ..blas import multiply
from ..body.body import Body
from ..body.skeleton import N_JOINTS, PARENTS
from .motion import Motion

GROUND_SAMPLE = 15
"""Every so many-th vertex is enough to find the lowest point of the body."""

GROUND_PERCENTILE = 2.0
"""The ground is where the lowest point of the body is in all but this share of the frames."""

FRAME_BLOCK = 64
"""Frames worked on at a time: few enough that a block's arrays stay in the processor's cache."""


def joint_transforms(body: Body, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Forward kinematics: where every joint is and how it is turned.

    Parameters
    ----------
    body : Body
    motion : Motion, T frames

    Returns
    -------
    rotations : ndarray, shape (T, 24, 3, 3)
        World rotation of each joint relative to the rest pose.
    positions : ndarray, shape (T, 24, 3)
        World position of each joint, metres.
    """
    rotations = np.empty_like(motion.rotations)
    positions = np.empty((motion.n_frames, N_JOINTS, 3))
    rotations[:, 0] = motion.rotations[:, 0]
    positions[:, 0] = motion.pelvis
    for joint in range(1, N_JOINTS):
        parent = PARENTS[joint]
        np.matmul(rotations[:, parent], motion.rotations[:, joint], out=rotations[:, joint])
        offset = body.joints[joint] - body.joints[parent]
        positions[:, joint] = positions[:, parent] + rotations[:, parent] @ offset
    return rotations, positions


def skinning_transforms(body: Body, motion: Motion) -> np.ndarray:
    """Affine maps from rest to posed space, one a joint and frame.

    Returns
    -------
    ndarray, shape (T, 24, 3, 4)
        Rotation and translation; a vertex is posed by their weighted sum.
    """
    rotations, positions = joint_transforms(body, motion)
    transforms = np.empty((motion.n_frames, N_JOINTS, 3, 4))
    transforms[..., :3] = rotations
    transforms[..., 3] = positions - np.einsum("tjab,jb->tja", rotations, body.joints)
    return transforms


def skin(body: Body, transforms: np.ndarray, vertices: np.ndarray | slice = slice(None)) -> np.ndarray:
    """Linear blend skinning of some vertices.

    Parameters
    ----------
    body : Body
    transforms : ndarray, shape (T, 24, 3, 4)
        From `skinning_transforms`; or of some axes of the world only, (T, 24, A, 4).
    vertices : ndarray of int, shape (N,), or slice
        Which vertices; all of them by default.

    Returns
    -------
    ndarray, shape (T, N, 3) or (T, N, A)
        World positions, metres.
    """
    return _blend(transforms, _skinning_rows(body.weights[vertices], body.vertices[vertices]))


def patch_matrices(body: Body, triangles: np.ndarray, motion: Motion) -> np.ndarray:
    """World matrix of every patch in every frame of a motion.

    Parameters
    ----------
    body : Body
    triangles : ndarray of int, shape (N, 3)
        Vertices of each patch's carrier triangle, as in `PatchSet.triangles`.
    motion : Motion, T frames

    Returns
    -------
    ndarray, shape (T, N, 4, 4), float64
    """
    return posed_patches(body, triangles, skinning_transforms(body, motion))


def posed_patches(body: Body, triangles: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """World matrix of every patch in every frame of a body that has been posed.

    The frame of a patch is that of Blender's three-vertex parent: x along v2 - v1, z the
    outward normal, y = z cross x, origin at the triangle's centroid. Skinning is linear in
    the rest position, so the centroid and the two edges of a triangle are skinned as three
    rows of one matrix product and no vertex is ever posed.

    Parameters
    ----------
    body : Body
    triangles : ndarray of int, shape (N, 3)
        Vertices of each patch's carrier triangle, as in `PatchSet.triangles`.
    transforms : ndarray, shape (T, 24, 3, 4)
        From `skinning_transforms`.

    Returns
    -------
    ndarray, shape (T, N, 4, 4), float64
        Entry by entry in memory, as whoever works on all matrices at once reads them.
    """
    n_frames, n_patches = len(transforms), len(triangles)
    rows = _triangle_rows(body, triangles)
    columns = transforms.transpose(0, 2, 1, 3).reshape(n_frames, 3, -1)
    entries = np.empty((4, 4, n_frames, n_patches))
    for start in range(0, n_frames, FRAME_BLOCK):
        part = slice(start, start + FRAME_BLOCK)
        blended = multiply(columns[part].reshape(-1, len(rows)), rows).reshape(-1, 3, 3, n_patches)
        _write_frames(entries[:, :, part], *blended.transpose(2, 1, 0, 3))
    return entries.transpose(2, 3, 0, 1)


def frames_from_edges(origin: np.ndarray, edge_x: np.ndarray, edge_b: np.ndarray) -> np.ndarray:
    """Right-handed frames from an origin and two edges of a triangle.

    Parameters
    ----------
    origin, edge_x, edge_b : ndarray, shape (..., 3)
        ``edge_x`` = v2 - v1 gives x; ``edge_x`` cross ``edge_b`` (v3 - v1) gives z.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Entry by entry in memory, as by `posed_patches`.
    """
    entries = np.empty((4, 4, *origin.shape[:-1]))
    _write_frames(entries, *(np.moveaxis(vector, -1, 0) for vector in (origin, edge_x, edge_b)))
    return np.moveaxis(entries, (0, 1), (-2, -1))


def triangle_frames(corners: np.ndarray) -> np.ndarray:
    """Frames at the centres of triangles, shape (..., 4, 4), from their corners (..., 3, 3)."""
    first, second, third = (corners[..., corner, :] for corner in range(3))
    frames = frames_from_edges(corners.mean(axis=-2), second - first, third - first)
    return np.ascontiguousarray(frames)  # one by one, as they are multiplied


def _write_frames(entries: np.ndarray, origin: np.ndarray, edge_x: np.ndarray, edge_b: np.ndarray) -> None:
    """Fill matrices (4, 4, ...) from vectors (3, ...): whole components are quick to work on."""
    x, y, z, place = (entries[:3, column] for column in range(4))
    np.divide(edge_x, _length(edge_x), out=x)
    _cross(edge_x, edge_b, out=z)
    z /= _length(z)
    _cross(z, x, out=y)
    place[...] = origin
    entries[3, :3], entries[3, 3] = 0.0, 1.0


def _cross(a: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """Cross product of vectors (3, ...)."""
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        np.multiply(a[second], b[third], out=out[axis])
        out[axis] -= a[third] * b[second]


def _length(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (3, ...)."""
    return np.sqrt((vectors * vectors).sum(axis=0))


def _skinning_rows(weights: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rows (24 * 4, N) that points' posed positions are the product of: w_j * (p, 1)."""
    homogeneous = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    return (weights.T[:, None] * homogeneous.T).reshape(-1, len(points))


def _triangle_rows(body: Body, triangles: np.ndarray) -> np.ndarray:
    """Rows for the centroids, then the edges v2 - v1, then the edges v3 - v1; (96, 3 N)."""
    first, second, third = (_skinning_rows(body.weights[t], body.vertices[t]) for t in triangles.T)
    return np.concatenate([(first + second + third) / 3, second - first, third - first], axis=1)


def _blend(transforms: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Multiply rows (96, N) with all frames' transforms (T, 24, A, 4) at once; shape (T, N, A)."""
    n_frames, n_axes = len(transforms), transforms.shape[2]
    columns = transforms.transpose(1, 3, 0, 2).reshape(N_JOINTS * 4, n_frames * n_axes)
    return multiply(rows.T, columns).reshape(-1, n_frames, n_axes).transpose(1, 0, 2)


def relative_to_parents(world: np.ndarray) -> np.ndarray:
    """Rotation of each joint relative to its parent, of the pelvis to the world.

    Parameters
    ----------
    world : ndarray, shape (T, 24, 3, 3)

    Returns
    -------
    ndarray, shape (T, 24, 3, 3)
    """
    local = world.copy()
    parents = list(PARENTS[1:])
    local[:, 1:] = world[:, parents].swapaxes(-1, -2) @ world[:, 1:]
    return local


def on_the_ground(body: Body, motion: Motion) -> Motion:
    """The same motion lifted or lowered as a whole until the body touches z = 0."""
    heights = skinning_transforms(body, motion)[:, :, 2:]
    lowest = skin(body, heights, slice(None, None, GROUND_SAMPLE))[:, :, 0].min(axis=1)
    pelvis = motion.pelvis.copy()
    pelvis[:, 2] -= np.percentile(lowest, GROUND_PERCENTILE)
    return Motion(motion.rotations, pelvis, motion.rate, motion.activity, motion.subject, motion.clip)
