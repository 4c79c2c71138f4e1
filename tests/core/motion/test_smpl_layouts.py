# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters of SMPL under other names and as matrices: the same motion as from AMASS's names."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.files import write_npz
from w2w.core.keypoints.facts import is_joint_file
from w2w.core.motion.motion import read_amass
from w2w.core.motion.source import UnusableMotion

N_FRAMES = 40


@pytest.fixture(scope="module")
def poses():
    """Axis-angle (T, 24, 3) of somebody who stands along y, as estimators have it."""
    found = np.random.default_rng(0).normal(scale=0.2, size=(N_FRAMES, 24, 3))
    found[:, 22:] = 0
    return found


@pytest.fixture(scope="module")
def path():
    return np.cumsum(np.random.default_rng(1).normal(scale=0.02, size=(N_FRAMES, 3)), axis=0)


def matrices(poses):
    return Rotation.from_rotvec(poses.reshape(-1, 3)).as_matrix().reshape(*poses.shape, 3)


def written(folder, **arrays):
    write_npz(folder / "a.npz", arrays)
    return folder / "a.npz"


@pytest.fixture
def expected(tmp_path, poses, path):
    parts = {"global_orient": poses[:, 0], "body_pose": poses[:, 1:], "transl": path}
    return read_amass(written(tmp_path, **parts, fps=np.array(30.0)), up="y")


LAYOUTS = {
    "HMR2": lambda p, t: {"global_orient": matrices(p[:, :1]), "body_pose": matrices(p[:, 1:]), "transl": t},
    "one matrix": lambda p, t: {
        "global_orient": matrices(p)[:, 0], "body_pose": matrices(p[:, 1:22]), "transl": t,
    },
    "AIST++": lambda p, t: {
        "smpl_poses": p.reshape(len(p), -1), "smpl_trans": 92.5 * t, "smpl_scaling": np.array([92.5]),
    },
    "WHAM": lambda p, t: {
        "pose": p.reshape(len(p), -1)[::-1], "trans": t[::-1], "trans_world": t,
        "pose_world": p.reshape(len(p), -1),
    },
    "TRAM": lambda p, t: {"pred_rotmat": matrices(p), "pred_trans": t[:, None]},
    "CoMotion": lambda p, t: {"pose": p.reshape(len(p), -1), "trans": t},
}  # fmt: skip


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_same_motion_comes_of_every_layout(tmp_path, poses, path, expected, layout):
    found = read_amass(written(tmp_path, **LAYOUTS[layout](poses, path)), 30.0, "y")
    np.testing.assert_allclose(found.rotations, expected.rotations, atol=1e-9)
    np.testing.assert_allclose(found.pelvis, expected.pelvis, atol=1e-9)


def test_without_a_path_the_body_moves_in_place(tmp_path, poses, expected):
    arrays = {"global_orient": poses[:, 0], "body_pose": poses[:, 1:]}
    found = read_amass(written(tmp_path, **arrays), 30.0, "y")
    np.testing.assert_array_equal(found.pelvis, np.broadcast_to(found.pelvis[0], (N_FRAMES, 3)))
    np.testing.assert_allclose(found.rotations, expected.rotations, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"global_orient": np.full((N_FRAMES, 1, 3, 3), 0.5)}, "not all are rotation matrices"),
        ({"body_pose": np.full((N_FRAMES, 23, 3, 3), np.nan)}, "not all are rotation matrices"),
        ({"body_pose": -np.tile(np.eye(3), (N_FRAMES, 23, 1, 1))}, "not all are rotation matrices"),
        ({"body_pose": np.tile(np.eye(3), (N_FRAMES, 7, 1, 1))}, r"have shape \(40, 24\)"),
        ({"transl": np.zeros((N_FRAMES, 2))}, r"'trans' has shape \(40, 2\)"),
    ],
)
def test_what_is_no_motion_is_said(tmp_path, poses, path, change, reason):
    arrays = LAYOUTS["HMR2"](poses, path) | change
    with pytest.raises(UnusableMotion, match=reason):
        read_amass(written(tmp_path, **arrays), 30.0)


@pytest.mark.parametrize("scale", [np.array(0.0), np.array([1.0, 2.0]), np.array("x")])
def test_a_path_over_no_number_is_refused(tmp_path, poses, path, scale):
    arrays = LAYOUTS["AIST++"](poses, path) | {"smpl_scaling": scale}
    with pytest.raises(UnusableMotion, match="its 'smpl_scaling' is no number above 0"):
        read_amass(written(tmp_path, **arrays), 60.0)


def test_rotations_come_before_joints_of_the_same_file(tmp_path, poses, path):
    joints = {"joints3d": np.zeros((N_FRAMES, 24, 3))}
    assert not is_joint_file(written(tmp_path, **LAYOUTS["TRAM"](poses, path), **joints))


def test_rotation_matrices_as_people_have_them(shared_cases):
    found = read_amass(shared_cases / "hmr2_rotmat.npz")
    with np.load(shared_cases / "hmr2_rotmat.npz") as arrays:
        knees = Rotation.from_matrix(arrays["body_pose"][:, 3]).magnitude()
    np.testing.assert_allclose(Rotation.from_matrix(found.rotations[:, 4]).magnitude(), knees, atol=1e-6)
