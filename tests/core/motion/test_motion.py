# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions to AMASS-style npz and back."""

import numpy as np
import pytest

from w2w.core.body.body import BODY_HANDS, N_JOINTS
from w2w.core.motion.motion import SMPL_PELVIS, Motion, read_amass
from w2w.core.motion.skinning import on_the_ground, skin, skinning_transforms
from w2w.core.motion.source import UnusableMotion


def test_round_trip_keeps_everything_but_the_hands(waving, tmp_path):
    waving.save(tmp_path / "clip.npz")
    read = read_amass(tmp_path / "clip.npz")
    body_joints = [joint for joint in range(N_JOINTS) if joint not in BODY_HANDS]
    np.testing.assert_allclose(read.rotations[:, body_joints], waving.rotations[:, body_joints], atol=1e-12)
    np.testing.assert_allclose(read.pelvis, waving.pelvis, atol=1e-12)
    assert read.rate == waving.rate


def test_saved_files_follow_amass(waving, tmp_path):
    waving.save(tmp_path / "clip.npz")
    with np.load(tmp_path / "clip.npz", allow_pickle=False) as data:
        assert data["poses"].shape == (60, 72)
        assert data["trans"].shape == (60, 3)
        assert data["mocap_framerate"] == 30
        assert [str(data[name]) for name in ("activity", "subject", "clip")] == ["waving", "one", "clip"]


def test_a_standing_body_has_amass_s_upright_root(tmp_path):
    motion = Motion(np.tile(np.eye(3), (4, N_JOINTS, 1, 1)), np.tile([0, 0, 1.0], (4, 1)), 30.0)
    motion.save(tmp_path / "clip.npz")
    with np.load(tmp_path / "clip.npz") as data:
        np.testing.assert_allclose(data["poses"][0, :3], [np.pi / 2, 0, 0], atol=1e-12)
        np.testing.assert_allclose(data["poses"][0, 3:], 0, atol=1e-12)
        np.testing.assert_allclose(data["trans"][0], [0, 0, 1] - SMPL_PELVIS)


def test_same_motion_gives_same_bytes(waving, tmp_path):
    waving.save(tmp_path / "a.npz")
    waving.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_real_amass_clip_stands_on_the_ground(shared_data, bundled_body):
    motion = on_the_ground(
        bundled_body, read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    )
    assert (motion.n_frames, motion.rate) == (601, 120.0)
    posed = skin(bundled_body, skinning_transforms(bundled_body, motion)[::60])
    heights = np.ptp(posed[..., 2], axis=1)
    assert (heights > 0.5 * bundled_body.height).all()
    assert abs(np.median(posed[..., 2].min(axis=1))) < 0.05


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("hbertiche__NeuralClothSim/0000.npz", r"\(19, 65, 4\)"),
        ("nghorbani__human_body_prior/body_pose_rnd.npz", "no 'poses'"),
        ("Meshcapade__smplcodec/apose_to_handsFront_smplx.npz", "frame rate"),
    ],
)
def test_impostors_are_refused_with_a_true_sentence(shared_data, file, reason):
    with pytest.raises(UnusableMotion, match=reason):
        read_amass(shared_data / "smpl_poses" / file)


def test_pickled_arrays_are_refused(tmp_path):
    np.savez(tmp_path / "evil.npz", poses=np.array([{"a": 1}], dtype=object), trans=np.zeros((1, 3)))
    with pytest.raises(UnusableMotion, match="neither numbers nor text"):
        read_amass(tmp_path / "evil.npz")


def test_values_that_are_not_finite_are_refused(waving, tmp_path):
    waving.save(tmp_path / "clip.npz")
    with np.load(tmp_path / "clip.npz") as data:
        arrays = dict(data)
    arrays["poses"][3, 5] = np.nan
    np.savez(tmp_path / "nan.npz", **arrays)
    with pytest.raises(UnusableMotion, match="not finite"):
        read_amass(tmp_path / "nan.npz")
