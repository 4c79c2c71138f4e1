# SPDX-License-Identifier: GPL-3.0-or-later
"""From MakeHuman's data to the bundled body, step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from w2w.core.body.body import MIRRORED_JOINTS, Body

from . import rig
from .cavities import close_cavities
from .makehuman import N_BODY_VERTICES, Source
from .remesh import remesh_half
from .sizing import detail, length_caps, wanted_lengths
from .surface import Surface, boundary_edges
from .weights import smooth_weights

N_FACES = 13_776
N_VERTICES = 6_890

FLIP = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True)
class PosedSource:
    """MakeHuman's neutral body in the T-pose, and the way there.

    Parameters
    ----------
    vertices : ndarray, shape (13380, 3)
    triangles : ndarray, shape (F, 3)
        Closed: without the cavities of mouth, eyes and nose.
    joints : ndarray, shape (24, 3)
    weights : ndarray, shape (13380, 24)
    ears : ndarray of bool, shape (13380,)
    t_pose : rig.TPose
    """

    vertices: np.ndarray
    triangles: np.ndarray
    joints: np.ndarray
    weights: np.ndarray
    ears: np.ndarray
    t_pose: rig.TPose


@dataclass(frozen=True)
class Binding:
    """Where the vertices of the bundled body's left half lie on the source.

    Parameters
    ----------
    corners : ndarray of int, shape (H, 3)
        Vertices of the source triangle.
    coordinates : ndarray, shape (H, 3)
        Barycentric coordinates in it.
    """

    corners: np.ndarray
    coordinates: np.ndarray

    def carry(self, values: np.ndarray) -> np.ndarray:
        """Values at the source's vertices (13380, ...) brought to the left half's (H, ...)."""
        return np.einsum("hk,hk...->h...", self.coordinates, values[self.corners])


def pose_source(source: Source) -> PosedSource:
    """The neutral body in the T-pose, closed."""
    a_pose = source.neutral()
    _, quads, cubes = source.mesh()
    weights = rig.group_weights(*source.rig_weights())[:N_BODY_VERTICES]
    joints = rig.joint_positions(a_pose, cubes)
    little, index = (a_pose[cubes[f"joint-l-finger-{finger}-1"]].mean(axis=0) for finger in (5, 2))
    t_pose = rig.TPose.of(joints, little - index)
    vertices, joints = t_pose.apply(a_pose[:N_BODY_VERTICES], joints, weights)
    ears = source.ears()[:N_BODY_VERTICES]
    quads = close_cavities(quads, vertices, source.mirror())
    return PosedSource(vertices, _shorter_diagonals(quads, vertices), joints, weights, ears, t_pose)


def make_body(posed: PosedSource) -> tuple[Body, Binding]:
    """The bundled body, and where its left half lies on the source."""
    used, left = _left_half(posed)
    vertices, weights = posed.vertices[used], posed.weights[used]
    caps = length_caps(vertices, posed.joints, weights, posed.ears[used])
    lengths = wanted_lengths(vertices, left, caps, detail(weights), N_FACES // 2)
    surface = Surface(vertices, left, lengths)
    half, half_faces = remesh_half(surface, N_FACES // 2)
    half, index, coordinates = _settle(surface, half, half_faces)
    binding = Binding(used[left[index]], coordinates)
    return _whole_body(half, half_faces, binding.carry(posed.weights), posed.joints), binding


def _settle(surface: Surface, half: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, ...]:
    """Round the remeshed half; its vertices, and the faces and coordinates that they are bound to."""
    seam = np.unique(boundary_edges(faces))
    normals = Surface(half, faces, np.ones(len(half))).vertex_normals
    _, index, coordinates = surface.closest_facing(half, normals)
    rounded = surface.rounded(half, index, coordinates)
    rounded[seam, 0] = 0
    return rounded, index, coordinates


def _whole_body(
    half: np.ndarray, half_faces: np.ndarray, half_weights: np.ndarray, joints: np.ndarray
) -> Body:
    """Mirror the left half, weld it along the seam and stand it on z = 0."""
    vertices, faces, mirror = _mirror_and_weld(half, half_faces)
    if (len(vertices), len(faces)) != (N_VERTICES, N_FACES):
        raise RuntimeError(
            f"the body has {len(vertices)} vertices and {len(faces)} faces: the half is no disk"
        )
    weights = smooth_weights(vertices, faces, _symmetric(half_weights, mirror))
    joints = (joints + joints[list(MIRRORED_JOINTS)] * FLIP) / 2
    floor = np.array([0, 0, vertices[:, 2].min()])
    return Body(
        vertices - floor,
        faces,
        joints - floor,
        _symmetric(weights[: len(half)], mirror),
        name="neutral",
        mirror=mirror,
    )


def _mirror_and_weld(half: np.ndarray, half_faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices and faces of both halves, the left one first, and every vertex's mirror image."""
    inner = np.setdiff1d(np.arange(len(half)), boundary_edges(half_faces))
    to_right = np.arange(len(half))
    to_right[inner] = len(half) + np.arange(len(inner))
    faces = np.concatenate([half_faces, to_right[half_faces][:, ::-1]])
    return np.concatenate([half, half[inner] * FLIP]), faces, np.concatenate([to_right, inner])


def _symmetric(half_weights: np.ndarray, mirror: np.ndarray) -> np.ndarray:
    """Weights of the left half given to both, and made symmetric on the seam."""
    flipped = list(MIRRORED_JOINTS)
    n_half = len(half_weights)
    weights = np.concatenate([half_weights, half_weights[mirror[n_half:]][:, flipped]])
    return (weights + weights[mirror][:, flipped]) / 2


def _left_half(posed: PosedSource) -> tuple[np.ndarray, np.ndarray]:
    """Source vertices used by the left half, and its triangles among them."""
    x = posed.vertices[posed.triangles, 0]
    tolerance = 1e-9
    left = posed.triangles[(x.min(axis=1) >= -tolerance) & (x.max(axis=1) > tolerance)]
    used, faces = np.unique(left, return_inverse=True)
    return used, faces.reshape(-1, 3)


def _shorter_diagonals(quads: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Split quads along the shorter diagonal; a quad with a doubled vertex gives one triangle."""
    first = np.linalg.norm(vertices[quads[:, 0]] - vertices[quads[:, 2]], axis=1)
    second = np.linalg.norm(vertices[quads[:, 1]] - vertices[quads[:, 3]], axis=1)
    halves = np.where(
        (first <= second)[:, None, None],
        quads[:, [[0, 1, 2], [0, 2, 3]]],
        quads[:, [[0, 1, 3], [1, 2, 3]]],
    ).reshape(-1, 3)
    return halves[(halves != np.roll(halves, 1, axis=1)).all(axis=1)]
