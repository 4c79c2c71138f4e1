# SPDX-License-Identifier: GPL-3.0-or-later
"""Forward kinematics, linear blend skinning of the vertices asked for, and the ground under a motion."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from ..blas import multiply
from ..body.body import N_JOINTS, PARENTS, Body, posed_joints
from ..rotations import cross, dot
from .motion import Motion

FRAME_BLOCK = 64
"""Frames worked on at a time: few enough that a block's arrays stay in the processor's cache."""


def joint_transforms(body: Body, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Forward kinematics: world rotations (T, 24, 3, 3) and positions (T, 24, 3), metres, of the joints.

    Rotations are relative to the rest pose.
    """
    return posed_joints(body.joints, motion.rotations, motion.pelvis)


def skinning_transforms(body: Body, motion: Motion, axes: slice = slice(None)) -> np.ndarray:
    """Affine maps (T, 24, 3, 4) from rest to posed space; a vertex is posed by their weighted sum.

    Only those to some `axes` of the world, (T, 24, A, 4), take less time.
    """
    rotations, positions = joint_transforms(body, motion)
    rotations = rotations[:, :, axes]
    transforms = np.empty((*rotations.shape[:3], 4))
    transforms[..., :3] = rotations
    joints = np.repeat(body.joints[:, None], rotations.shape[2], axis=1)  # einsum is slow to spread them
    transforms[..., 3] = positions[..., axes] - np.einsum("tjab,jab->tja", rotations, joints)
    return transforms


def skin(body: Body, transforms: np.ndarray, vertices: np.ndarray | slice = slice(None)) -> np.ndarray:
    """Linear blend skinning of some vertices, by default all: world positions (T, N, 3), metres.

    Transforms are those of `skinning_transforms`, or only some axes of the world, (T, 24, A, 4), for (T, N,
    A).
    """
    rows = _skinning_rows(body.weights[vertices], body.vertices[vertices])
    n_frames, n_axes = len(transforms), transforms.shape[2]
    columns = transforms.transpose(1, 3, 0, 2).reshape(N_JOINTS * 4, n_frames * n_axes)
    return multiply(rows.T, columns).reshape(-1, n_frames, n_axes).transpose(1, 0, 2)


def patch_matrices(body: Body, triangles: np.ndarray, motion: Motion) -> np.ndarray:
    """World matrix (T, N, 4, 4), float64, of every patch in every frame of a motion; see `posed_patches`."""
    return posed_patches(body, triangles, skinning_transforms(body, motion))


def posed_patches(body: Body, triangles: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """World matrix (T, N, 4, 4), float64, of every patch in every frame of a body that has been posed.

    The frame of a patch is that of Blender's three-vertex parent: x along v2 - v1, z the outward normal, y =
    z cross x, origin at the triangle's centroid. Skinning is linear in the rest position, so the centroid and
    the two edges of a triangle are skinned as three rows of one matrix product and no vertex is ever posed.

    Triangles (N, 3) are `PatchSet.triangles`, transforms those of `skinning_transforms`. The matrices lie in
    memory entry by entry, the layout that vectorised readers need.
    """
    n_frames, n_patches = len(transforms), len(triangles)
    rows = _triangle_rows(body, triangles.astype(np.intp).tobytes())
    columns = transforms.transpose(0, 2, 1, 3).reshape(n_frames, 3, -1)
    entries = np.empty((4, 4, n_frames, n_patches))
    for start in range(0, n_frames, FRAME_BLOCK):
        part = slice(start, start + FRAME_BLOCK)
        blended = multiply(columns[part].reshape(-1, len(rows)), rows).reshape(-1, 3, 3, n_patches)
        _write_frames(entries[:, :, part], *blended.transpose(2, 1, 0, 3))
    return entries.transpose(2, 3, 0, 1)


def frames_from_edges(origin: np.ndarray, edge_x: np.ndarray, edge_b: np.ndarray) -> np.ndarray:
    """Right-handed frames (..., 4, 4) from an origin and two edges of a triangle, (..., 3) each.

    x runs along `edge_x`, v2 - v1; z along its cross product with `edge_b`, v3 - v1. Entry by entry in
    memory, as by `posed_patches`.
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
    np.divide(edge_x, np.sqrt(dot(edge_x, edge_x)), out=x)
    cross(edge_x, edge_b, out=z)
    z /= np.sqrt(dot(z, z))
    cross(z, x, out=y)
    place[...] = origin
    entries[3, :3], entries[3, 3] = 0.0, 1.0


def _skinning_rows(weights: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rows (24 * 4, N) that points' posed positions are the product of: w_j * (p, 1)."""
    homogeneous = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    return (weights.T[:, None] * homogeneous.T).reshape(-1, len(points))


@lru_cache(maxsize=4)  # chunks of sensors come again with each clip
def _triangle_rows(body: Body, triangles: bytes) -> np.ndarray:
    """Rows (24 * 4, 3 N) for the centroids of triangles (N, 3), and for two edges of each."""
    corners = np.frombuffer(triangles, dtype=np.intp).reshape(-1, 3).T
    first, second, third = (_skinning_rows(body.weights[t], body.vertices[t]) for t in corners)
    return np.concatenate([(first + second + third) / 3, second - first, third - first], axis=1)


def relative_to_parents(world: np.ndarray) -> np.ndarray:
    """Rotations (T, 24, 3, 3) of joints relative to their parents, of the pelvis to the world."""
    local = world.copy()
    parents = list(PARENTS[1:])
    local[:, 1:] = world[:, parents].swapaxes(-1, -2) @ world[:, 1:]
    return local


SAMPLE = 15
"""Every fifteenth vertex is enough to find the lowest point of the body."""

PERCENTILE = 2.0
"""The body's lowest point is above the ground in all but this share of the frames."""

SUNK, HIGH = 0.1, 0.3
"""Metres by which a source sinks that is lower between its ends than at both; one by more came down."""

HELD_S, STEADY = 0.1, 0.03
"""Seconds at either end in which the lowest point of a body that stands rises or falls by less (m)."""

IN_PLACE = 0.5
"""Metres that a pelvis moves sideways at most in a clip that sinks: further down may be a step."""

RAMP_S = 0.05
"""Seconds in which a sinking body is lifted before it would be below the ground."""


def on_the_ground(body: Body, motion: Motion) -> Motion:
    """The same motion lifted or lowered as a whole until the body touches z = 0.

    One whose source sinks between its ends is level with its ends, and lifted by itself where it sinks.
    """
    heights = skinning_transforms(body, motion, slice(2, None))
    lowest = skin(body, heights, slice(None, None, SAMPLE))[:, :, 0].min(axis=1)
    pelvis = motion.pelvis.copy()
    ground = np.percentile(lowest, PERCENTILE)
    level = _level_of_ends(lowest, motion)
    if SUNK < level - ground < HIGH:
        pelvis[:, 2] += _lift(level - lowest, motion.rate)
        ground = level
    pelvis[:, 2] -= ground
    return replace(motion, pelvis=pelvis)


def _level_of_ends(lowest: np.ndarray, motion: Motion) -> float:
    """Height of a body in place that is steady at its ends, -inf of any other, by its lowest points (T,)."""
    held = max(round(HELD_S * motion.rate), 2)
    ends = lowest[:held], lowest[-held:]
    levels = [float(np.median(end)) for end in ends]
    steady = all(np.ptp(end) < STEADY for end in ends) and abs(levels[0] - levels[1]) < SUNK / 2
    in_place = np.linalg.norm(motion.pelvis[:, :2] - motion.pelvis[0, :2], axis=1).max() < IN_PLACE
    return min(levels) if steady and in_place else -np.inf


def _lift(depth: np.ndarray, rate: float) -> np.ndarray:
    """Smooth heights (T,) that are nowhere less than the depths (T,) below the ground, metres."""
    half = round(RAMP_S * rate)
    highest = maximum_filter1d(np.maximum(depth, 0.0), 4 * half + 1)
    return uniform_filter1d(uniform_filter1d(highest, 2 * half + 1), 2 * half + 1)
