# SPDX-License-Identifier: GPL-3.0-or-later
"""Forward kinematics, skinning and patch frames against closed forms and vertex-by-vertex sums."""

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS, PARENTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import (
    frames_from_edges,
    joint_transforms,
    patch_matrices,
    skin,
    skinning_transforms,
)


def still(n_frames=3):
    return Motion(np.tile(np.eye(3), (n_frames, N_JOINTS, 1, 1)), np.zeros((n_frames, 3)), 30.0)


class Patches:
    """Only what `patch_matrices` reads of a PatchSet."""

    def __init__(self, triangles):
        self.triangles = triangles


def test_identity_pose_is_the_rest_pose(bundled_body):
    motion = still()
    motion = Motion(motion.rotations, np.tile(bundled_body.joints[0], (3, 1)), 30.0)
    posed = skin(bundled_body, skinning_transforms(bundled_body, motion))
    np.testing.assert_allclose(posed, np.broadcast_to(bundled_body.vertices, posed.shape), atol=1e-12)


def test_bone_lengths_never_change(bundled_body, waving):
    _, positions = joint_transforms(bundled_body, waving)
    for joint in range(1, N_JOINTS):
        length = np.linalg.norm(positions[:, joint] - positions[:, PARENTS[joint]], axis=1)
        rest = np.linalg.norm(bundled_body.joints[joint] - bundled_body.joints[PARENTS[joint]])
        np.testing.assert_allclose(length, rest, rtol=1e-12)


def test_a_bent_elbow_turns_the_forearm_about_the_elbow(bundled_body):
    elbow, wrist = JOINT_INDEX["left_elbow"], JOINT_INDEX["left_wrist"]
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    rotations[0, elbow] = Rotation.from_euler("z", -90, degrees=True).as_matrix()
    _, positions = joint_transforms(bundled_body, Motion(rotations, bundled_body.joints[:1], 1.0))
    rest = bundled_body.joints[wrist] - bundled_body.joints[elbow]
    np.testing.assert_allclose(
        positions[0, wrist] - positions[0, elbow], [rest[1], -rest[0], rest[2]], atol=1e-12
    )


def test_skinning_some_vertices_equals_a_sum_over_joints(bundled_body, waving):
    chosen = np.arange(0, len(bundled_body.vertices), 97)
    rotations, positions = joint_transforms(bundled_body, waving)
    expected = np.zeros((waving.n_frames, len(chosen), 3))
    for joint in range(N_JOINTS):
        local = bundled_body.vertices[chosen] - bundled_body.joints[joint]
        carried = np.einsum("tab,nb->tna", rotations[:, joint], local) + positions[:, None, joint]
        expected += bundled_body.weights[chosen, joint, None] * carried
    posed = skin(bundled_body, skinning_transforms(bundled_body, waving), chosen)
    np.testing.assert_allclose(posed, expected, atol=1e-12)


def test_patch_frames_are_those_of_the_posed_triangles(bundled_body, waving):
    triangles = bundled_body.faces[::431]
    matrices = patch_matrices(bundled_body, triangles, waving)
    corners = skin(bundled_body, skinning_transforms(bundled_body, waving), triangles.ravel())
    corners = corners.reshape(waving.n_frames, len(triangles), 3, 3)
    np.testing.assert_allclose(matrices[..., :3, 3], corners.mean(axis=2), atol=1e-12)
    x = corners[:, :, 1] - corners[:, :, 0]
    normal = np.cross(x, corners[:, :, 2] - corners[:, :, 0])
    np.testing.assert_allclose(np.sum(matrices[..., :3, 0] * x, -1), np.linalg.norm(x, axis=-1))
    np.testing.assert_allclose(np.sum(matrices[..., :3, 2] * normal, -1), np.linalg.norm(normal, axis=-1))


def test_patch_frames_are_right_handed_and_orthonormal(bundled_body, waving):
    matrices = patch_matrices(bundled_body, bundled_body.faces[::613], waving)
    turns = matrices[..., :3, :3]
    np.testing.assert_allclose(
        turns @ turns.swapaxes(-1, -2), np.broadcast_to(np.eye(3), turns.shape), atol=1e-10
    )
    np.testing.assert_allclose(np.linalg.det(turns), 1)


def test_normals_of_patches_point_outward(bundled_body):
    corners = bundled_body.vertices[bundled_body.faces]
    matrices = frames_from_edges(
        corners.mean(axis=1), corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    )
    agree = np.sum(matrices[:, :3, 2] * bundled_body.vertex_normals[bundled_body.faces[:, 0]], axis=1)
    assert np.mean(agree > 0) > 0.99
